//! Bags message by message: the meaning of each type, at its time.

use std::path::Path as FilePath;

use ilon_messages::Message;
use ilon_messages::bag::{BagWriter, Qos};
use ilon_messages::builtin_interfaces::Time;
use ilon_messages::geometry_msgs::{Pose, PoseStamped, Quaternion, Twist, TwistStamped, Vector3};
use ilon_messages::nav_msgs::{Odometry, Path};
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::std_msgs::{Float64MultiArray, String as Words};
use ilon_sim::{Error, Run, Scenario, run};

const ROBOT: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../../assets/robots/mecanum4.urdf"
);
const WHEELS: [&str; 4] = ["front_left", "front_right", "rear_left", "rear_right"];
/// Start of the bag, with a message that drives nothing; the others come from a second later on.
const BEGINS_NS: u64 = 4_000_000_000;

/// A bag in a folder, of one topic's messages at times in seconds from a second after its start.
fn bag<M: Message>(folder: &FilePath, messages: &[(f64, M)]) {
    let mut bag = BagWriter::create(&folder.join("bag")).expect("a bag");
    bag.declare::<Words>("/other", Qos::reliable(1))
        .expect("a topic");
    bag.declare::<M>("/asked", Qos::reliable(1))
        .expect("a topic");
    bag.write("/other", &Words::default(), BEGINS_NS)
        .expect("a message");
    for (t_s, message) in messages {
        let time_ns = BEGINS_NS + 1_000_000_000 + (1e9 * t_s).round() as u64;
        bag.write("/asked", message, time_ns).expect("a message");
    }
    bag.finish().expect("a bag");
}

/// The run of messages that drive the robot.
fn played<M: Message>(drives: &str, messages: &[(f64, M)], further: &str) -> Result<Run, Error> {
    let folder = tempfile::tempdir().expect("a folder");
    bag(folder.path(), messages);
    let text = format!(
        "[robot]\nfile = \"{ROBOT}\"\n[playback]\nfile = \"bag\"\ndrives = \"{drives}\"\ntopic = \"/asked\"\n{further}"
    );
    let mut scenario = Scenario::from_toml(&text, "test", folder.path())?;
    scenario.folder = folder.path().to_owned();
    run(&scenario)
}

fn refused<M: Message>(drives: &str, messages: &[(f64, M)]) -> String {
    let refused = played(drives, messages, "");
    refused
        .map(|run| run.summary)
        .expect_err("it is refused")
        .to_string()
}

fn twist([x, y, turn]: [f64; 3]) -> Twist {
    Twist {
        linear: Vector3 { x, y, z: 7.0 },
        angular: Vector3 {
            x: 8.0,
            y: 9.0,
            z: turn,
        },
    }
}

/// From 0, 0.3 and 0.6 s on.
const TWISTS: [(f64, [f64; 3]); 3] = [
    (0.0, [0.1, 0.0, 0.0]),
    (0.3, [0.2, -0.15, 0.4]),
    (0.6, [0.0, 0.1, 0.0]),
];

#[test]
fn every_type_with_a_velocity_says_the_same() {
    let plain = TWISTS.map(|(t_s, values)| (t_s, twist(values)));
    let stamped = plain.map(|(t_s, twist)| {
        let stamped = TwistStamped {
            twist,
            ..TwistStamped::default()
        };
        (t_s, stamped)
    });
    let odometry = plain.map(|(t_s, twist)| {
        let mut odometry = Odometry::default();
        odometry.twist.twist = twist;
        (t_s, odometry)
    });
    let runs = [
        played("twist", &plain, ""),
        played("twist", &stamped, ""),
        played("twist", &odometry, ""),
    ];
    for run in runs.map(|run| run.expect("a run")) {
        // The last one holds for the interval of messages.
        assert!((run.summary.duration_s - 0.9).abs() < 1e-9);
        for record in run.trace.records() {
            let asked = record.command_twist_in_body;
            let asked = [asked.vx_m_s, asked.vy_m_s, asked.omega_rad_s];
            let from = TWISTS.iter().rfind(|(t_s, _)| *t_s <= record.t_s + 1e-9);
            assert_eq!(asked, from.expect("one holds").1, "{} s", record.t_s);
        }
    }
}

/// Rotated by a heading and then tilted to the side.
fn pose(x_m: f64, heading_rad: f64, lean_rad: f64) -> Pose {
    let ((s, c), (sl, cl)) = (
        libm::sincos(0.5 * heading_rad),
        libm::sincos(0.5 * lean_rad),
    );
    let mut pose = Pose::default();
    pose.position.x = x_m;
    pose.orientation = Quaternion {
        x: c * sl,
        y: s * sl,
        z: s * cl,
        w: c * cl,
    };
    pose
}

#[test]
fn a_pose_has_the_heading_that_its_lean_leaves() {
    let messages =
        [(0.0, 0.2, 0.0), (0.3, 0.7, 0.5), (0.6, 1.2, -0.8)].map(|(t_s, heading, lean)| {
            let mut odometry = Odometry::default();
            odometry.pose.pose = pose(t_s, heading, lean);
            odometry.twist.twist = twist([0.1, 0.0, 0.0]);
            (t_s, odometry)
        });
    let run = played("twist", &messages, "pose_topic = \"/asked\"\n").expect("a run");
    for record in run.trace.records().iter().filter(|record| record.t_s < 0.6) {
        let measured = record.measured.expect("a pose at each time");
        // Linear interpolation between messages; the first one is at the robot's start.
        let turned_rad = 0.5 / 0.3 * record.t_s;
        assert!(
            (measured.heading_rad - turned_rad).abs() < 1e-9,
            "{measured:?}"
        );
        assert!(
            (measured.position_m().norm() - record.t_s).abs() < 1e-9,
            "{measured:?}"
        );
    }
}

fn path(stamps_ns: &[u64]) -> Path {
    let poses = stamps_ns.iter().enumerate().map(|(index, stamp_ns)| {
        let mut stamped = PoseStamped::default();
        stamped.header.stamp = Time {
            sec: (stamp_ns / 1_000_000_000) as i32,
            nanosec: (stamp_ns % 1_000_000_000) as u32,
        };
        stamped.pose = pose(0.05 * index as f64, 0.0, 0.0);
        stamped
    });
    Path {
        poses: poses.collect(),
        ..Path::default()
    }
}

#[test]
fn a_path_is_driven_at_the_times_of_its_poses() {
    let stamps_ns = [
        100_250_000_000,
        100_750_000_000,
        101_250_000_000,
        101_750_000_000,
    ];
    let run = played("path", &[(0.0, path(&stamps_ns))], "").expect("a run");
    assert!(
        (run.summary.duration_s - 1.5).abs() < 1e-9,
        "{}",
        run.summary.duration_s
    );
    for (t_s, x_m) in [(0.0, 0.0), (0.5, 0.05), (1.0, 0.1)] {
        let at = |record: &&ilon_trace::Record| record.t_s > t_s - 1e-9;
        let record = run.trace.records().iter().find(at).expect("a row");
        let desired = record.desired.expect("a path").pose;
        assert!((desired.x_m - x_m).abs() < 1e-6, "{desired:?}");
    }
    // For poses of one message at a time, the recording's times count.
    let messages = [0.0, 0.5, 1.0].map(|t_s| {
        let stamped = PoseStamped {
            pose: pose(0.1 * t_s, 0.0, 0.0),
            ..PoseStamped::default()
        };
        (t_s, stamped)
    });
    let run = played("path", &messages, "").expect("a run");
    assert!((run.summary.duration_s - 1.0).abs() < 1e-9);
    let twice = path(&[1_000_000_000, 2_000_000_000, 2_000_000_000]);
    assert!(refused("path", &[(0.0, twice)]).contains("no increasing times"));
}

fn joints(names: &[&str], values: &[f64]) -> JointState {
    JointState {
        name: names.iter().map(|name| (*name).to_owned()).collect(),
        velocity: values.to_vec(),
        ..JointState::default()
    }
}

#[test]
fn joints_are_found_by_their_names_and_others_passed_over() {
    let renamed: String = WHEELS
        .iter()
        .enumerate()
        .map(|(index, wheel)| format!("{wheel} = \"j{index}\"\n"))
        .collect();
    let messages = [
        (
            0.0,
            joints(&["j3", "arm", "j1", "j0", "j2"], &[3.0, 9.0, 1.0, 0.5, 2.0]),
        ),
        (0.1, joints(&["arm", "head"], &[7.0, 7.0])),
        (0.2, joints(&["j0", "j1", "j2", "j3"], &[])),
        (
            0.3,
            joints(&["j0", "j1", "j2", "j3"], &[4.0, 5.0, 6.0, 7.0]),
        ),
        (0.6, joints(&["j0", "j1", "j2", "j3"], &[0.0; 4])),
    ];
    let further = format!("[playback.names]\n{renamed}");
    let run = played("wheel_rates", &messages, &further).expect("a run");
    for (record, wheels) in run.trace.steps() {
        let expected = match record.t_s + 1e-9 {
            t_s if t_s < 0.3 => [0.5, 1.0, 2.0, 3.0],
            t_s if t_s < 0.6 => [4.0, 5.0, 6.0, 7.0],
            _ => [0.0; 4],
        };
        let targets: Vec<f64> = wheels.iter().map(|wheel| wheel.target_rad_s).collect();
        assert_eq!(targets, expected, "{} s", record.t_s);
    }
    let plain = |data: &[f64]| Float64MultiArray {
        data: data.to_vec(),
        ..Float64MultiArray::default()
    };
    let run = played(
        "wheel_rates",
        &[(0.0, plain(&[1.0, 2.0, 3.0, 4.0])), (0.5, plain(&[0.0; 4]))],
        "",
    );
    let run = run.expect("a run");
    let first = run.trace.steps().next().expect("a row").1;
    assert_eq!(first[2].target_rad_s, 3.0);
    let short = refused("wheel_rates", &[(0.0, plain(&[1.0, 2.0, 3.0]))]);
    assert!(
        short.contains("has 3 numbers, but the robot 4 wheels"),
        "{short}"
    );
}

#[test]
fn what_cannot_be_computed_with_is_placed_from_the_beginning_of_the_bag() {
    for bad in [f64::NAN, f64::INFINITY, 1.1e9, -1.1e9] {
        let messages = [(0.0, twist([0.1, 0.0, 0.0])), (0.3, twist([0.1, bad, 0.0]))];
        let said = refused("twist", &messages);
        assert!(
            said.contains("`/asked`, 1.300 s after the first of all, holds a number"),
            "{said}"
        );
    }
}
