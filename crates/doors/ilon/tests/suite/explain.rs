//! `ilon explain`: every cause of a scenario by the run without it, and what the usual suspects do to a robot; `ilon run` of a robot alone.

use crate::support;

use support::{Folder, ended_with};

/// What is reported of a fault is the difference to the run that the same command makes without it.
#[test]
fn a_cause_is_told_by_the_run_without_it() {
    let folder = Folder::new();
    let push = "[[faults]]\npush = { impulse_y_n_s = 10, from_s = 0.4 }\n";
    folder.scenario("pushed.toml", push);
    folder.scenario("alone.toml", "");
    let json = |arguments: &[&str]| -> serde_json::Value {
        let output = folder.ilon(arguments);
        ended_with(0, &output);
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let found = json(&["explain", "pushed.toml", "--json", "--out", "explained"]);
    let alone = json(&[
        "run",
        "alone.toml",
        "--json",
        "--no-twins",
        "--out",
        "alone",
    ]);
    let causes = found["causes"].as_array().expect("a list");
    let push = causes.iter().find(|cause| cause["cause"] == "faults.0");
    let push = push.expect("the push is a cause");
    assert_eq!(push["words"], "the push of 10 N s at 0.40 s");
    assert_eq!(push["differs"], true);
    let effects = push["effects"].as_array().expect("a list");
    let place = effects.iter().find(|effect| effect["key"] == "end_y_m");
    assert_eq!(place.expect("a place")["without"], alone["end_y_m"]);
    // The largest first.
    let apart = |cause: &serde_json::Value| cause["apart"]["most_m"].as_f64().expect("a length");
    assert!(
        causes
            .windows(2)
            .all(|two| apart(&two[0]) >= apart(&two[1]))
    );
    // The page, and the summary, say the same.
    let summary: serde_json::Value =
        serde_json::from_str(&folder.read("explained/summary.json")).expect("JSON");
    let told = summary["effects"].as_array().expect("a list");
    assert!(told.iter().any(|effect| effect["cause"] == "sliding"));
    assert!(
        folder
            .read("explained/report.html")
            .contains("id=\"causes\"")
    );
}

/// A wheel of four that rolls 1 % less turns an omnidirectional robot by a known amount: its row of the inverse of M is a quarter of each motion.
#[test]
fn what_is_seen_of_a_robot_is_laid_at_a_wheel() {
    let folder = Folder::new();
    let robot = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4.urdf"
    );
    let json = |arguments: &[&str]| -> serde_json::Value {
        let output = folder.ilon(arguments);
        ended_with(0, &output);
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let found = json(&[
        "explain",
        robot,
        "--json",
        "--seen",
        "left 12.8 mm/m, turn 0.92 deg/m",
    ]);
    let best = &found["suspects"][0];
    assert_eq!(best["words"], "front_left 1 % smaller than the others");
    // Twice of what 1 % does.
    let times = best["times"].as_f64().expect("a number");
    assert!((times - 2.0).abs() < 0.1, "{times}");
    let ahead = best["drifts"][0]["ahead_m"].as_f64().expect("a number");
    assert!((ahead + 0.0025).abs() < 5e-5, "{ahead}");
}

#[test]
fn what_cannot_be_seen_is_refused() {
    let folder = Folder::new();
    let robot = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4.urdf"
    );
    for (arguments, said) in [
        (["explain", robot, "--seen", "up 3 mm/m"], "is no drift"),
        (
            ["explain", "good.toml", "--seen", "left 3 mm/m"],
            "this is a scenario",
        ),
    ] {
        let printed = ended_with(2, &folder.ilon(&arguments));
        assert!(printed.contains(said), "{printed}");
    }
}

/// A robot alone is driven in five motions; what is written can be run again, and is not written over once it was changed.
#[test]
fn a_robot_alone_is_driven_in_five_motions() {
    let folder = Folder::new();
    let printed = ended_with(0, &folder.ilon(&["run", "robot.urdf", "--no-report"]));
    for motion in ["ahead", "left", "diagonal", "arc", "turn"] {
        assert!(printed.contains(motion), "{printed}");
        let summary = folder.read(&format!("out/robot/{motion}/summary.json"));
        assert!(summary.contains("twist_ratio_asked"));
    }
    ended_with(
        0,
        &folder.ilon(&["run", "out/robot/left.toml", "--no-report", "--no-twins"]),
    );
    folder.write("out/robot/left.toml", "# mine\n");
    let refused = ended_with(2, &folder.ilon(&["run", "robot.urdf", "--no-report"]));
    assert!(
        refused.contains("was not written by this command"),
        "{refused}"
    );
    let refused = ended_with(2, &folder.ilon(&["run", "good.toml", "robot.urdf"]));
    assert!(refused.contains("is a robot, not a scenario"), "{refused}");
}
