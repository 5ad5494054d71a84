//! `ilon live --ros2` against other ROS 2 implementations: rclpy over Fast DDS and CycloneDDS, in
//! `ros2_witness.py`.
//!
//! Each case runs in its own network with only a loopback interface, so that cases do not receive
//! each other's messages or those of the machine. That needs Linux and permission to create such a
//! network.

#![cfg(feature = "ros2")]

use std::process::Command;

/// Brings the loopback interface of a fresh network up, with multicast.
const NETWORK: &str =
    "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo";

/// A Python with rclpy and cyclonedds: that of `ILON_ROS2_PYTHON`.
fn python() -> Option<String> {
    let Ok(python) = std::env::var("ILON_ROS2_PYTHON") else {
        println!(
            "skipped: ILON_ROS2_PYTHON names no Python with what tests/ros2_requirements.txt lists"
        );
        return None;
    };
    let tried = Command::new(&python)
        .args(["-c", "import rclpy, cyclonedds"])
        .output();
    assert!(
        tried.is_ok_and(|output| output.status.success()),
        "{python}, named by ILON_ROS2_PYTHON, lacks what tests/ros2_requirements.txt lists"
    );
    let network = Command::new("unshare")
        .args(["-n", "sh", "-c", NETWORK])
        .output();
    if network.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    println!("skipped: a network of its own cannot be made here (unshare -n)");
    None
}

fn holds(case: &str) {
    let Some(python) = python() else { return };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/ros2_witness.py");
    let output = Command::new("unshare")
        .args(["-n", "sh", "-c", &format!("{NETWORK} && exec \"$@\""), "sh"])
        .args([
            "timeout",
            "200",
            &python,
            script,
            env!("CARGO_BIN_EXE_ilon"),
            case,
        ])
        .output()
        .expect("Python runs");
    print!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(
        output.status.success(),
        "{case}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn every_topic_reaches_rclpy() {
    holds("topics");
}

#[test]
fn who_comes_late_gets_a_large_description() {
    holds("late");
}

#[test]
fn a_stamped_twist_drives_and_what_makes_no_sense_is_said() {
    holds("drive");
}

#[test]
fn a_twist_drives_where_it_is_asked_for() {
    holds("unstamped");
}

#[test]
fn controllers_drive_the_wheels() {
    holds("wheels");
}

#[test]
fn either_side_may_go_and_come_again() {
    holds("restart");
}

#[test]
fn it_leaves_the_graph_however_it_ends() {
    holds("leave");
}

#[test]
fn two_robots_in_a_domain_each_have_a_namespace() {
    holds("namespaces");
}

#[test]
fn the_example_drives_its_square() {
    holds("square");
}

#[test]
fn cyclonedds_hears_drives_and_steps() {
    holds("cyclone");
}

#[test]
fn parameters_are_set_by_a_client_of_ros() {
    holds("parameters");
}

#[test]
fn the_environment_counts() {
    holds("environment");
}
