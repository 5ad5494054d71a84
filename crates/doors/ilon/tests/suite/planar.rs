//! `ilon export --planar`: a planar base, whose stated errors an independent program confirms.

use std::path::Path;
use std::process::Command;

use approx::assert_relative_eq;
use serde_json::Value;
use test_case::test_case;

use crate::support::{Folder, ended_with, python, stderr};

/// The JSON output of a Python script.
fn said(python: &str, script: &Path, arguments: &[&str]) -> Value {
    let output = Command::new(python)
        .arg(script)
        .args(arguments)
        .output()
        .expect("Python runs");
    assert!(output.status.success(), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        value => vec![value.as_f64().unwrap_or(f64::NAN)],
    }
}

fn assets(robot: &str) -> String {
    format!(
        "{}/../../../assets/robots/{robot}",
        env!("CARGO_MANIFEST_DIR")
    )
}

/// The lateral shortfalls are those that the lateral scenarios measure: rigid rollers of four
/// mecanum wheels lose 2 %, omni wheels whose rollers run on one circle nothing.
#[test_case("mecanum4.urdf", 0.02)]
#[test_case("optiodom_omni3.toml", 0.002)]
#[test_case("volksbot.urdf", 0.0)]
fn a_planar_base_is_as_far_off_as_it_says(robot: &str, sideways: f64) {
    let folder = Folder::new();
    ended_with(
        0,
        &folder.ilon(&["export", "--planar", &assets(robot), "--out", "base"]),
    );
    let mut names = folder.names("base");
    names.sort();
    assert_eq!(names, ["held_out.csv", "planar.json", "planar.py"]);
    let base: Value = serde_json::from_str(&folder.read("base/planar.json")).unwrap();

    let s = numbers(&base["shortfall"]["matrix"]);
    // Over 2 s of a drive, in which each roller's passage still shows.
    assert_relative_eq!(s[4], 1.0 - sideways, epsilon = 2e-3);
    assert_relative_eq!(s[0], 1.0, epsilon = 3e-3);
    // Grip gives at most the friction limit, with every wheel pushing along its rollers' axles.
    let (most, friction) = (
        numbers(&base["grip"]["most"]),
        base["friction"].as_f64().unwrap(),
    );
    assert!(
        most[..2]
            .iter()
            .all(|a| (0.3 * 9.81 * friction..9.81 * friction).contains(a)),
        "{most:?}"
    );
    // Its error is below that of ideal kinematics in each axis, by at least a third.
    let held_out = &base["held_out"];
    let [model, ideal] = ["model", "ideal"].map(|of| numbers(&held_out[of]["twist_rms"]));
    for (axis, (model, ideal)) in model.iter().zip(&ideal).enumerate() {
        assert!(
            *model < 0.67 * ideal,
            "axis {axis}: {model} against {ideal}"
        );
    }

    if let Some(python) = python("numpy") {
        let found = said(&python, &folder.path("base/planar.py"), &[]);
        for key in ["twist_rms", "position_over_path", "heading_rms_rad"] {
            for (found, stated) in numbers(&found[key])
                .iter()
                .zip(numbers(&held_out["model"][key]))
            {
                // The drives are written to seven decimals, over paths of metres in thousands of
                // steps.
                assert_relative_eq!(*found, stated, epsilon = 1e-5);
            }
        }
    }
}

/// The same robot gives the same bytes, and its floor matters.
#[test]
fn the_floor_counts_and_nothing_is_chance() {
    let folder = Folder::new();
    let export = |out: &str, friction: &str| {
        let friction = format!("world.floor.friction={friction}");
        let robot = assets("mecanum4.urdf");
        ended_with(
            0,
            &folder.ilon(&[
                "export", "--planar", &robot, "--out", out, "--set", &friction,
            ]),
        );
        folder.read(&format!("{out}/planar.json"))
    };
    let [once, again, slippery] =
        [("once", "0.4"), ("again", "0.4"), ("slippery", "0.2")].map(|(out, of)| export(out, of));
    assert_eq!(once, again);
    let [most, most_slippery] = [once, slippery]
        .map(|json| numbers(&serde_json::from_str::<Value>(&json).unwrap()["grip"]["most"]));
    for (of, of_slippery) in most.iter().zip(&most_slippery).take(2) {
        // Sliding starts follow Coulomb's law, except for their last part without sliding.
        assert_relative_eq!(of_slippery / of, 0.5, epsilon = 0.05);
    }
}

#[test]
fn what_has_no_planar_base_is_refused_in_words() {
    let folder = Folder::new();
    for (arguments, words) in [
        (&["--planar", "none.urdf"][..], "none.urdf"),
        (&["--planar", "good.toml"], "is a scenario, not a robot"),
        (
            &["--planar", "robot.urdf", "--fmu", "good.toml"],
            "cannot be used with",
        ),
        (
            &["--planar", "robot.urdf", "--library", "x.so"],
            "cannot be used with",
        ),
        (
            &[
                "--planar",
                "robot.urdf",
                "--set",
                "world.floor.friction=0.0",
            ],
            "does not reach half",
        ),
        (
            &["--planar", "robot.urdf", "--set", "world.floor.grip=1"],
            "grip",
        ),
        (
            &["--planar", "robot.urdf", "--out", "good.toml"],
            "good.toml",
        ),
    ] {
        let said = ended_with(2, &folder.ilon(&[&["export"], arguments].concat()));
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
    assert!(!folder.path("robot_planar/planar.json").exists());
}

/// Tyres hold a robot sideways, or are steered first: that is said, not that it lacks grip.
#[test]
fn of_a_robot_on_tyres_the_true_reason_is_said() {
    let folder = Folder::new();
    for robot in ["tricycle.urdf", "swerve4.urdf"] {
        let said = ended_with(
            2,
            &folder.ilon(&["export", "--planar", &assets(robot), "--out", "base"]),
        );
        assert!(
            said.contains("the tyre of") && !said.contains("friction"),
            "{said}"
        );
    }
}
