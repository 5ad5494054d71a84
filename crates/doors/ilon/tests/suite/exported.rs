//! `ilon export ROBOT --mjcf` and for other simulators: wheels with their real rollers, and the
//! error of their motion there.

use std::process::Command;

use serde_json::Value;
use test_case::test_case;

use crate::support::{Folder, ended_with, python};

/// A robot's file, written into the folder if needed.
fn robot(folder: &Folder, name: &str) -> String {
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    let crown = match name {
        "crowned" => 0.8,
        "slightly crowned" => 0.9,
        "turned" => 1.0,
        _ => return format!("{assets}/{name}"),
    };
    let urdf = std::fs::read_to_string(format!("{assets}/mecanum4.urdf")).unwrap();
    let outline = match name {
        // Two cones and a cylinder between them, as long as neighbours need to hand over.
        "turned" => {
            "profile=\"-0.01956 0.0099 -0.006 0.01195 0.006 0.01195 0.01956 0.0099\"".into()
        }
        _ => format!("crown=\"{crown}\""),
    };
    let made: String = ["front_left", "front_right", "rear_left", "rear_right"]
        .map(|wheel| format!("<ilon_rollers joint=\"{wheel}\" {outline}/>"))
        .concat();
    folder.write(
        "crowned.urdf",
        &urdf.replace("</robot>", &(made + "</robot>")),
    );
    folder.path("crowned.urdf").display().to_string()
}

fn exported(folder: &Folder, name: &str, options: &[&str]) -> Vec<Value> {
    let robot = robot(folder, name);
    let command: &[&str] = &["export", &robot, "--json", "--out", "there"];
    let command = [command, options].concat();
    let output = folder.ilon(&command);
    ended_with(0, &output);
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// The contact kinematics of the fitted shapes is that of the real rollers, to 0.1 %. Each file is
/// a robot that ilon reads, with as many wheels of the same radius.
#[test_case("mecanum4.urdf", 4, 0.05)]
#[test_case("crowned", 4, 0.05021)]
#[test_case("volksbot.urdf", 3, 0.05)]
#[test_case("mecanum6.urdf", 6, 0.0762)]
fn shapes_drive_as_the_rollers_do(name: &str, wheels: usize, radius_m: f64) {
    let folder = Folder::new();
    for format in exported(&folder, name, &["--mjcf", "--sdf", "--urdf"]) {
        // The travel of a hub is at most twice the error of its height, and must stay below 0.1 mm.
        assert!(format["fit_error_mm"].as_f64().unwrap() < 0.05, "{format}");
        for drive in format["drives"].as_array().unwrap() {
            let of = |key: &str| drive[key].as_f64().unwrap();
            assert!((of("expected") - of("as_made")).abs() < 1e-3, "{drive}");
        }
    }
    let names = folder.names("there");
    for ending in ["_scene.xml", ".sdf", ".urdf"] {
        let file = names.iter().find(|name| name.ends_with(ending)).unwrap();
        let read = folder.ilon(&[
            "inspect",
            &format!("there/{file}"),
            "--as-modelled",
            "--json",
        ]);
        ended_with(0, &read);
        let read: Value = serde_json::from_slice(&read.stdout).unwrap();
        let read = read["wheels"].as_array().unwrap();
        assert_eq!(read.len(), wheels, "{file}");
        for wheel in read {
            // For crowned rollers the mean height of the hub: 1.0042 times 50 mm.
            let read_m = wheel["radius_m"].as_f64().unwrap();
            assert!(
                (read_m - radius_m).abs() < 1e-3 * radius_m,
                "{file}: {read_m}"
            );
        }
    }
}

/// MuJoCo at a step of 2 ms is within 0.1 % of ilon.
#[test_case("mecanum4.urdf")]
#[test_case("volksbot.urdf")]
#[test_case("mecanum6.urdf")]
#[test_case("optiodom_omni3.toml")]
#[test_case("crowned")]
#[test_case("slightly crowned")]
#[test_case("turned")]
fn mujoco_drives_as_ilon_does(name: &str) {
    if python("mujoco,numpy").is_none() {
        return;
    }
    let folder = Folder::new();
    let said = exported(&folder, name, &["--mjcf", "--verify"]);
    for drive in said[0]["drives"].as_array().unwrap() {
        let of = |key: &str| drive[key].as_f64().unwrap();
        assert!((of("measured") - of("ilon")).abs() < 1e-3, "{drive}");
    }
    assert_eq!(said[0]["verdict"]["agrees"], true, "{}", said[0]);
}

/// At rest in MuJoCo a roller sinks by 4e-4 of the wheel's radius, whatever the wheels weigh. That
/// follows from the inverse mass of the robot as one body on free wheels; what turns with a wheel
/// and moves with the robot is counted in both, which is a few hundredths of it.
#[test_case("mecanum4.urdf")]
#[test_case("mecanum6.urdf")]
#[test_case("optiodom_omni3.toml")]
fn rollers_sink_in_mujoco_as_far_as_is_meant(name: &str) {
    const PROGRAM: &str = "
import json, sys, mujoco
about = json.load(open('there/drive.json'))
model = mujoco.MjModel.from_xml_path('there/' + about['model'])
data = mujoco.MjData(model)
mujoco.mj_step(model, data, 1000)
radius = 1.0 / max(abs(row[axis]) for row in about['drives'][0]['rate_matrix'] for axis in (0, 1))
print(-sum(contact.dist for contact in data.contact) / len(data.contact) / radius)";
    let Some(python) = python("mujoco,numpy") else {
        return;
    };
    let folder = Folder::new();
    exported(&folder, name, &["--mjcf"]);
    let output = Command::new(python)
        .args(["-c", PROGRAM])
        .current_dir(folder.path("."))
        .output()
        .unwrap();
    ended_with(0, &output);
    let sag: f64 = String::from_utf8_lossy(&output.stdout)
        .trim()
        .parse()
        .unwrap();
    assert!((sag / 4e-4 - 1.0).abs() < 0.1, "{sag}");
}

/// The library that Gazebo reads SDF with finds no fault in a model or world, and all their joints.
/// Debian's knows SDF up to 1.9, which has all that these files use.
#[test]
fn the_library_of_sdf_reads_what_is_written() {
    let flags = Command::new("pkg-config")
        .args(["--cflags", "--libs", "sdformat12"])
        .output();
    let Some(flags) = flags.ok().filter(|output| output.status.success()) else {
        println!("skipped: there is no sdformat12; `apt-get install libsdformat-dev`");
        return;
    };
    let folder = Folder::new();
    exported(&folder, "mecanum4.urdf", &["--sdf"]);
    for name in ["mecanum4.sdf", "mecanum4_world.sdf"] {
        let text = std::fs::read_to_string(folder.path("there").join(name)).unwrap();
        folder.write(name, &text.replace("version=\"1.11\"", "version=\"1.9\""));
    }
    folder.write(
        "read.cc",
        "#include <sdf/sdf.hh>\n#include <iostream>\nint main(int, char **names) {\n\
         for (++names; *names; ++names) {\n  sdf::Root root;\n  for (auto &error : root.Load(*names)) std::cout << error.Message() << '\\n';\n\
         auto model = root.Model() ? root.Model() : root.WorldByIndex(0)->ModelByName(\"mecanum4\");\n\
         std::cout << model->JointCount() << '\\n';\n}\n}\n",
    );
    let compiled = Command::new("c++")
        .args(["-std=c++17", "read.cc", "-o", "read"])
        .args(String::from_utf8(flags.stdout).unwrap().split_whitespace())
        .current_dir(folder.path("."))
        .output()
        .unwrap();
    ended_with(0, &compiled);
    let read = Command::new(folder.path("read"))
        .args(["mecanum4.sdf", "mecanum4_world.sdf"])
        .current_dir(folder.path("."))
        .output()
        .unwrap();
    ended_with(0, &read);
    // Four wheels of nine rollers.
    assert_eq!(String::from_utf8_lossy(&read.stdout), "40\n40\n");
    assert_eq!(String::from_utf8_lossy(&read.stderr), "");
}

/// Newton steps the same file in single precision, and is within 0.15 % of ilon.
#[test_case("mecanum4.urdf")]
#[test_case("volksbot.urdf")]
#[test_case("mecanum6.urdf")]
#[test_case("optiodom_omni3.toml")]
fn newton_drives_as_ilon_does(name: &str) {
    let Ok(newton) = std::env::var("ILON_NEWTON_PYTHON") else {
        println!("skipped: ILON_NEWTON_PYTHON names no Python with `newton[sim]`");
        return;
    };
    let folder = Folder::new();
    let robot = robot(&folder, name);
    let mut command = folder.command(&[
        "export", &robot, "--newton", "--verify", "--json", "--out", "there",
    ]);
    let output = command.env("ILON_PYTHON", newton).output().unwrap();
    ended_with(0, &output);
    let said: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let drives = said[0]["drives"].as_array().unwrap();
    assert_eq!(drives.len(), 3);
    for drive in drives {
        let of = |key: &str| drive[key].as_f64().unwrap();
        assert!((of("measured") - of("ilon")).abs() < 1.5e-3, "{drive}");
    }
    assert!(folder.path("there/drive_newton.py").is_file());
}
