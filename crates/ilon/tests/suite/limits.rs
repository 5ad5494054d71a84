//! `ilon inspect --limits`: how hard a robot may be driven.

use crate::support::{Folder, ended_with, stdout};

/// The largest acceleration from rest of a motion, with its cause.
fn from_rest(json: &serde_json::Value, motion: &str) -> (f64, String) {
    let rows = json["limits"]["rows"].as_array().expect("rows");
    let row = rows
        .iter()
        .find(|row| row["motion"] == motion && row["speed"] == 0.0)
        .expect("a row at rest");
    let limit = &row["speeding_up"];
    let cause = limit["cause"].as_str().expect("a cause").to_owned();
    (limit["largest"].as_f64().expect("a number"), cause)
}

/// Half of the friction leaves about half of the acceleration; a motor of a hundredth of a newton metre is what is short.
#[test]
fn limits_follow_the_conditions_that_are_set() {
    let folder = Folder::new();
    let inspected = |further: &[&str]| -> serde_json::Value {
        let mut arguments = vec!["inspect", "robot.urdf", "--limits", "--json"];
        arguments.extend(further);
        let out = folder.ilon(&arguments);
        ended_with(0, &out);
        serde_json::from_str(&stdout(&out)).expect("JSON")
    };
    let grippy = from_rest(&inspected(&["--set", "world.floor.friction=0.4"]), "back");
    let slippery = from_rest(&inspected(&["--set", "world.floor.friction=0.2"]), "back");
    let ratio = slippery.0 / grippy.0;
    assert!((0.5..0.6).contains(&ratio), "{ratio}");
    assert_eq!(slippery.1, "grip");
    let weak = "motors.dc={stall_torque_n_m=0.01,no_load_rate_rad_s=20}";
    assert_eq!(from_rest(&inspected(&["--set", weak]), "ahead").1, "motor");
}

#[test]
fn the_table_names_wheels_and_what_is_set_for_nothing_is_refused() {
    let folder = Folder::new();
    let table = folder.ilon(&[
        "inspect",
        "robot.urdf",
        "--limits",
        "--ros2-controllers",
        "c.yaml",
    ]);
    let words = stdout(&table);
    assert!(
        words.contains("turning left") && words.contains("wheel_1"),
        "{words}"
    );
    let yaml = folder.read("c.yaml");
    assert!(
        yaml.contains("ax_max: ") && yaml.contains("max_decel: [-"),
        "{yaml}"
    );
    let idle = folder.ilon(&["inspect", "robot.urdf", "--set", "world.floor.friction=0.2"]);
    assert!(ended_with(2, &idle).contains("add --limits"));
    let key = "world.flor.friction=1";
    let unknown = folder.ilon(&["inspect", "robot.urdf", "--limits", "--set", key]);
    assert!(ended_with(2, &unknown).contains("did you mean `floor`"));
}
