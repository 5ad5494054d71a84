//! Logs of a simulated robot on rollers of a known form, with noise and whole ticks.

use std::fmt::Write;
use std::path::Path;

use ilon_identify::{Identified, Study, identify};
use ilon_sim::scenario::Scenario;
use ilon_sim::{Driver, Plant, WheelCommand, load_robot, resolve_for};

const STEPS: &str =
    "run.physics_dt_s = 0.004\nrun.control_dt_s = 0.02\nrobot.roller_bodies = \"near\"\n";

/// Tracker noise of 0.1 mm, and encoders of 4096 ticks per turn.
const TICK_RAD: f64 = std::f64::consts::TAU / 4096.0;
const NOISE_M: f64 = 1e-4;

/// A drive at steady wheel rates on rollers with these keys, as a text table with rows every 0.1 s.
fn drive(robot: &Path, keys: &str, rates_rad_s: [f64; 4], seed: u64) -> String {
    let text = format!(
        "robot.file = {robot:?}\ntwist.vx_m_s = 0.1\nrun.duration_s = 100.0\n{STEPS}{keys}\n"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.toml");
    std::fs::write(&path, text).unwrap();
    let scenario = Scenario::load(&path).unwrap();
    let robot = load_robot(&scenario).unwrap();
    let resolved = resolve_for(&scenario, &robot, Driver::Own).unwrap();
    let mut plant = Plant::new(&resolved, &robot).unwrap();
    let mut state = seed;
    let mut noise_m = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        // Uniform, of standard deviation 1.
        NOISE_M * 12.0_f64.sqrt() * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    };
    let mut table = "t,x,y,heading,w1,w2,w3,w4\n".to_owned();
    for row in 0..60 {
        plant
            .advance(WheelCommand::Rates(&rates_rad_s), 0.1)
            .unwrap();
        let pose = plant.truth().pose;
        let _ = write!(
            table,
            "{},{},{},{}",
            0.1 * f64::from(row),
            pose.x_m + noise_m(),
            pose.y_m + noise_m(),
            pose.heading_rad
        );
        for angle_rad in &plant.observe().wheel_angles_rad {
            let _ = write!(table, ",{}", (angle_rad / TICK_RAD).round() * TICK_RAD);
        }
        table.push('\n');
    }
    table
}

/// A study of drives ahead, sideways and diagonally on rollers with some keys fixed and others
/// free.
fn studied(truth: &str, free: &str) -> Result<Identified, ilon_sim::Error> {
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots/mecanum4.urdf");
    let folder = tempfile::tempdir().unwrap();
    let mut runs = String::new();
    let rates = [
        [3.0, 3.0, 3.0, 3.0],
        [-3.0, 3.0, 3.0, -3.0],
        [3.0, -3.0, -3.0, 3.0],
        [0.0, 4.0, 4.0, 0.0],
        [-4.0, 0.0, 0.0, -4.0],
        [-3.0, -3.0, -3.0, -3.0],
    ];
    for (index, rates) in rates.into_iter().enumerate() {
        let name = format!("drive_{index}.csv");
        std::fs::write(
            folder.path().join(&name),
            drive(&robot, truth, rates, index as u64 + 1),
        )
        .unwrap();
        let _ = write!(runs, "[[runs]]\nfile = \"{name}\"\n");
    }
    let wheels = ["front_left", "front_right", "rear_left", "rear_right"];
    let mut columns = String::new();
    for (index, wheel) in wheels.iter().enumerate() {
        let _ = writeln!(
            columns,
            "{wheel} = {{ column = \"w{}\", unit = \"rad\" }}",
            index + 1
        );
    }
    let study = format!(
        "robot = {robot:?}\n[log]\ntime = {{ column = \"t\", unit = \"s\" }}\nx = {{ column = \"x\", unit = \"m\" }}\n\
         y = {{ column = \"y\", unit = \"m\" }}\nheading = {{ column = \"heading\", unit = \"rad\" }}\n[log.wheels]\n{columns}\
         [set]\n{STEPS}[simulate]\ndrive_s = 2.0\nsteps = 6\nphases = 1\n[simulate.free]\n{free}\n{runs}"
    );
    let path = folder.path().join("study.toml");
    std::fs::write(&path, study).unwrap();
    identify(&Study::load(&path)?, &|_| ())
}

/// The crown of rollers (how much flatter than the ideal barrel) shows in the robot's paths. It is
/// found with its interval around it, if drives begin at the wheel angles of the simulation, as the
/// study states (`phases = 1`). Drives that begin at random angles: `tests/phases.rs`.
#[test]
#[ignore = "minutes: .ci/nightly"]
fn the_crown_of_rollers_is_found_from_the_ways() {
    let found = studied(
        "rollers.crown = 0.6",
        "rollers.crown = { from = 0.3, to = 1.3 }",
    )
    .unwrap();
    let crown = &found.parameters["rollers.crown"];
    println!(
        "{crown:?} {:?}",
        found.simulation.as_ref().map(|s| (&s.open, &s.insensitive))
    );
    let [low, high] = crown
        .ci95
        .map(|end| end.expect("drives of many directions"));
    assert!(low < 0.6 && 0.6 < high, "{crown:?}");
    assert!((crown.value - 0.6).abs() < 0.1, "{crown:?}");
}

/// If the range of a key contains impossible robots, that is reported before any simulation.
#[test]
fn a_range_that_no_robot_can_have_is_refused_with_its_end() {
    let error = studied(
        "rollers.crown = 0.6",
        "rollers.crown = { from = 0.3, to = 60.0 }",
    )
    .unwrap_err();
    let said = error.to_string();
    println!("{said}");
    assert!(
        said.contains("`simulate.free.rollers.crown` reaches 60"),
        "{said}"
    );
}
