//! The core of the plugin for Gazebo, in a physics engine of a few lines.

use std::process::Command;

use crate::examples::{build_file, example};
use crate::support::{root, scenario};

/// The program's output for a scene of a given mass, of which a share is declared to ilon; `None`
/// without a compiler.
fn driven(scene_kg: f64, said: f64) -> Option<Vec<Vec<f64>>> {
    let folder = tempfile::tempdir().unwrap();
    let ours = root().join("crates/doors/ilon-c");
    let include = format!("-I{}", ours.join("gz").display());
    let source = ours.join("tests/gz_core.cpp");
    let program = build_file("c++", &source, &["-std=c++17", &include], folder.path())?;
    let output = example(program)
        .arg(scenario("mecanum4_lateral.toml"))
        .args([scene_kg.to_string(), said.to_string()])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("wheels")
            && said.contains("nowhere.toml")
            && said.contains("cannot be advanced"),
        "{said}"
    );
    let text = String::from_utf8(output.stdout).unwrap();
    let row = |line: &str| line.split(' ').map(|x| x.parse().unwrap()).collect();
    Some(text.lines().map(row).collect())
}

/// A mass welded to the base moves it as a payload of the same mass does, though it weighs twice as
/// much as the robot and acts one step late. This holds if ilon knows all of the mass, or as much
/// as stability needs.
#[test]
fn a_weld_moves_the_base_as_a_payload_does() {
    for (scene_kg, said) in [(2.0, 1.0), (20.0, 1.0), (20.0, 0.6), (2.0, 0.0)] {
        let Some(rows) = driven(scene_kg, said) else {
            return;
        };
        let [alone, coupled, about, refused] = rows.as_slice() else {
            panic!("{rows:?}");
        };
        println!("{scene_kg} kg, {said} of it said: {rows:?}");
        // The start takes about 0.1 s of the second; a delay of several milliseconds in it changes
        // the path by less than a hundredth.
        for axis in [0, 1, 3] {
            let off = (coupled[axis] - alone[axis]).abs();
            assert!(
                off < 0.01 * alone[axis].abs(),
                "{scene_kg} kg, {said}: axis {axis}, {rows:?}"
            );
        }
        // The momentum that the scene takes within a step is off by its share of the engine's base,
        // and is corrected in the next step.
        assert!(about[0] < 2e-3 * scene_kg * 0.4 / 20.0, "{about:?}");
        // The base's work is the scene's kinetic energy, as the scene's height does not change.
        let [work_j, kinetic_j] = [about[1], about[2]];
        assert!((work_j - kinetic_j).abs() < 2e-3 * kinetic_j, "{about:?}");
        assert_eq!(refused[0], 5.0);
        assert_eq!(refused[1..3], [1.0, 2.0]);
    }
}

/// The plugin itself is compiled if Gazebo is installed.
#[test]
fn the_plugin_is_built_where_gazebo_is() {
    let folder = tempfile::tempdir().unwrap();
    let configured = Command::new("cmake")
        .arg("-S")
        .arg(root().join("examples/gazebo"))
        .arg("-B")
        .arg(folder.path())
        .output();
    let Ok(configured) = configured else {
        println!("skipped: there is no cmake");
        return;
    };
    let said = String::from_utf8_lossy(&configured.stdout).into_owned();
    let wrong = String::from_utf8_lossy(&configured.stderr).into_owned();
    assert!(configured.status.success(), "{said}{wrong}");
    if said.contains("gz-sim is not installed") {
        println!("skipped: gz-sim is not installed");
        return;
    }
    // Compiled but not linked: the library of a release need not exist.
    let built = Command::new("cmake")
        .arg("--build")
        .arg(folder.path())
        .args(["--target", "IlonBase.o"])
        .output()
        .unwrap();
    assert!(
        built.status.success(),
        "{}",
        String::from_utf8_lossy(&built.stderr)
    );
}
