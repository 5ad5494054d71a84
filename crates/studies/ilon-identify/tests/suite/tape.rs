//! Runs of known robots whose ends were measured with a tape and a protractor.

use std::fmt::Write;

use ilon_files::FileAccess;
use ilon_identify::model::Model;
use ilon_identify::tape::{Tape, TapeFit};
use ilon_robot::{Pose, Robot, Twist};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};

use crate::support::{assets, robot};

/// The drives: metres ahead and to the left, and radians, three times each.
const DRIVES: [[f64; 3]; 4] = [
    [2.0, 0.0, 0.0],
    [0.0, 2.0, 0.0],
    [0.0, 0.0, 18.85],
    [0.8, 0.8, 1.5],
];
const ERROR_M: f64 = 2e-3;
const ERROR_DEG: f64 = 0.5;

/// A file of runs of a robot with these parameters; the wheels turn as commanded for the nominal
/// robot.
fn tape(file: &str, robot: &Robot, free: &[&str], values: &[f64], seed: u64) -> String {
    let free: Vec<String> = free.iter().map(|name| (*name).to_owned()).collect();
    let model = Model::new(robot, &free).unwrap();
    let truth = model.twist_matrix(values).unwrap();
    let known = ilon_control::Kinematics::new(robot).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (place, turn) = (
        Normal::new(0.0, ERROR_M).unwrap(),
        Normal::new(0.0, ERROR_DEG).unwrap(),
    );
    let path = assets().join("robots").join(file);
    let mut text = format!(
        "robot = {:?}\nfree = {free:?}\n",
        path.display().to_string()
    );
    for drive in DRIVES.iter().cycle().take(3 * DRIVES.len()) {
        let mut turned = vec![0.0; robot.wheels.len()];
        known.wheel_rates(Twist::new(drive[0], drive[1], drive[2]), &mut turned);
        let went = &truth * nalgebra::DVector::from_column_slice(&turned);
        let end = Pose::default().moved(Twist::new(went[0], went[1], went[2]));
        let wheels = robot.wheels.iter().zip(&turned);
        let wheels: Vec<String> = wheels
            .map(|(wheel, rad)| format!("{} = {rad:.6}", wheel.name))
            .collect();
        // A protractor does not count full turns.
        let heading_deg =
            (went[2].to_degrees() + turn.sample(&mut rng) + 180.0).rem_euclid(360.0) - 180.0;
        writeln!(
            text,
            "[[measured]]\nwheels = {{ {} }}\nx_m = {:.5}\ny_m = {:.5}\nheading_deg = {heading_deg:.3}\nerror_m = {ERROR_M}\nerror_deg = {ERROR_DEG}",
            wheels.join(", "),
            end.x_m + place.sample(&mut rng),
            end.y_m + place.sample(&mut rng)
        )
        .unwrap();
    }
    text
}

fn fitted(text: &str) -> TapeFit {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tape.toml");
    std::fs::write(&path, text).unwrap();
    let tape = Tape::load_within(&path, &FileAccess::anywhere()).unwrap();
    tape.expect("runs by tape").fit().unwrap()
}

/// 2 m ahead, measured to 2 mm three times, determine the radius to 2e-3 / 2 / sqrt(3) of it:
/// 0.03 mm of 50; three turns, measured to half a degree three times, the lever to
/// 0.5 / 1080 / sqrt(3) of 310 mm: 0.08 mm; the radius adds 6e-4 of it, 0.18 mm.
#[test]
fn radius_and_lever_are_found_within_their_intervals() {
    let robot = robot("mecanum4.urdf");
    let truth = [0.0493, 0.316];
    let mut covered = [0; 2];
    for seed in 0..40 {
        let found = fitted(&tape(
            "mecanum4.urdf",
            &robot,
            &["radius_m", "lever_m"],
            &truth,
            seed,
        ));
        for (axis, (name, half_mm)) in [("radius_m", 0.06), ("lever_m", 0.5)]
            .into_iter()
            .enumerate()
        {
            let value = &found.parameters[name];
            let [Some(low), Some(high)] = value.ci95 else {
                panic!("{value:?}")
            };
            assert!(1e3 * (high - low) / 2.0 < 2.5 * half_mm, "{name} {value:?}");
            covered[axis] += i32::from(low <= truth[axis] && truth[axis] <= high);
        }
        assert!(found.held.is_empty(), "{:?}", found.held);
    }
    // 95 % of 40 are 38; fewer than 34 occur once in 200 times.
    assert!(covered.iter().all(|count| *count >= 34), "{covered:?}");
}

/// Two wheels whose axes differ from the nominal directions by 6 and -4 degrees: three runs of each
/// drive determine each axis to several tenths of a degree.
#[test]
fn axes_that_stand_otherwise_are_found() {
    let robot = robot("volksbot.urdf");
    let free = ["radius_m", "axis_deg.*"];
    let names: Vec<String> = free.map(str::to_owned).to_vec();
    let model = Model::new(&robot, &names).unwrap();
    let mut truth = model.nominal();
    truth[1] += 6.0;
    truth[2] -= 4.0;
    let found = fitted(&tape("volksbot.urdf", &robot, &free, &truth, 3));
    for (name, value) in model.names().iter().zip(&truth) {
        let [Some(low), Some(high)] = found.parameters[name].ci95 else {
            panic!("{name}")
        };
        assert!(
            low <= *value && *value <= high,
            "{name}: {value} {:?}",
            found.parameters[name]
        );
        let widest = if name == "radius_m" {
            2e-3 * value
        } else {
            1.0
        };
        assert!(high - low < widest, "{name}: {:?}", found.parameters[name]);
    }
    // No controller of ros2_controllers drives wheels that do not face outward.
    assert_eq!(found.controller.kind, None);
}

/// A run that ended behind the robot, though its wheels drove ahead, needs a negative radius: its
/// sign is wrong.
#[test]
fn a_run_with_the_wrong_sign_is_refused_and_makes_no_negative_radius() {
    let path = assets().join("robots/mecanum4.urdf");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tape.toml");
    let text = format!(
        "robot = {:?}\n[[measured]]\ndrive = {{ vx_m_s = 0.4, for_s = 5 }}\nx_m = -1.97\n",
        path.display().to_string()
    );
    std::fs::write(&file, text).unwrap();
    let tape = Tape::load_within(&file, &FileAccess::anywhere()).unwrap();
    let error = tape.expect("runs by tape").fit().unwrap_err().to_string();
    assert!(error.contains("`radius_m` = -0.049"), "{error}");
}

/// Drives ahead alone do not determine the lever; the table says that turns would.
#[test]
fn what_the_runs_do_not_tell_is_held_and_the_drive_that_would_is_named() {
    let path = assets().join("robots/mecanum4.urdf");
    let found = fitted(&format!(
        "robot = {:?}\n[[measured]]\ndrive = {{ vx_m_s = 0.4, for_s = 5 }}\nx_m = 1.97\nerror_m = 0.002\n",
        path.display().to_string()
    ));
    // 2 m were commanded with 50 mm and 1.97 m were reached.
    assert!(
        (found.parameters["radius_m"].value - 0.985 * 0.05).abs() < 1e-6,
        "{found:?}"
    );
    assert_eq!(found.held.len(), 1);
    assert_eq!(found.held[0].name, "lever_m");
    let lever_m = |drive: &str| {
        found
            .next
            .iter()
            .find(|of| of.drive.contains(drive))
            .unwrap()
            .errors["lever_m"]
    };
    // 2 m measured once to 2 mm leave 1e-3 of the radius, 0.31 mm of the lever; half a degree of
    // three times three turns leaves 0.083 mm.
    assert!((lever_m("turns") - 3.2e-4).abs() < 1e-5, "{:?}", found.next);
    assert!(
        lever_m("2 m ahead") > 0.9 * lever_m("none"),
        "{:?}",
        found.next
    );
}

/// A robot on tyres: the radius of each wheel and half of the track are found within their
/// intervals, and what cannot be driven is not proposed.
#[test]
fn a_differential_robot_is_fitted() {
    let robot = robot("differential.urdf");
    // The wheels, and half of the track.
    let truth = [0.0605, 0.0597, 0.173];
    let free = ["radius_m.*", "lever_m"];
    let fit = fitted(&tape("differential.urdf", &robot, &free, &truth, 3));
    assert!(fit.held.is_empty(), "{:?}", fit.held);
    for (name, truth) in ["radius_m.left", "radius_m.right", "lever_m"]
        .iter()
        .zip(truth)
    {
        let found = &fit.parameters[*name];
        let half = found.ci95[1].expect("an interval") - found.value;
        // 2 mm of 2 m and half a degree of three turns: each interval is below a hundredth.
        assert!(half < 0.01 * truth, "{name}: {found:?}");
        // One interval in twenty misses its truth; none by twice.
        assert!(
            (found.value - truth).abs() < 2.0 * half,
            "{name}: {found:?}"
        );
    }
    assert_eq!(
        fit.controller.kind,
        Some(ilon_identify::outcome::ControllerKind::Differential)
    );
    let words = |drive: &str| drive.contains("left") || drive.contains("sideways");
    assert!(!fit.next.iter().any(|next| words(&next.drive)));
}

#[test]
fn a_robot_that_is_steered_is_refused() {
    let error = Model::new(&robot("swerve4.urdf"), &["radius_m".to_owned()]).expect_err("steered");
    let words = format!("{error:?}");
    assert!(words.contains("steering angle"), "{words}");
}

/// A robot as ilon drives it, on rollers that touch beside the middle of their wheels: it falls 2 %
/// short sideways and turns 1 % less, by geometry alone. Nothing of it differs from its file, and a
/// controller that has no rollers is given what they take.
#[test]
fn what_rollers_take_is_no_fault_of_the_robot() {
    let file = assets().join("robots").join("mecanum4.urdf");
    let mut text = format!("robot = {:?}\n", file.display().to_string());
    for twist in ["vx_m_s = 0.4", "vy_m_s = 0.4", "omega_rad_s = 1.2"] {
        let scenario = format!(
            "robot.file = {:?}\ntwist = {{ {twist}, rest_s = 0.1 }}\nrun.duration_s = 5.0\n",
            file.display().to_string()
        );
        let scenario = ilon_sim::Scenario::from_toml(&scenario, "tape", "").unwrap();
        let trace = ilon_sim::run(&scenario).unwrap().trace;
        let (record, samples) = trace.steps().last().unwrap();
        let wheels = trace.header.wheels.iter().zip(samples);
        let wheels: Vec<String> = wheels
            .map(|(wheel, sample)| format!("{} = {}", wheel.name, sample.angle_rad))
            .collect();
        let end = record.truth.pose;
        writeln!(
            text,
            "[[measured]]\nwheels = {{ {} }}\nx_m = {}\ny_m = {}\nheading_deg = {}",
            wheels.join(", "),
            end.x_m,
            end.y_m,
            end.heading_rad.to_degrees()
        )
        .unwrap();
    }
    let found = fitted(&text);
    let [ahead, sideways, turn] = found.rollers.expect("they explain it");
    let robot = robot("mecanum4.urdf");
    let at = robot.wheels[0].position_m();
    for (name, nominal) in [("radius_m", 0.05), ("lever_m", at.x.abs() + at.y.abs())] {
        let value = found.parameters[name].value;
        assert!((value / nominal - 1.0).abs() < 2e-3, "{name} {value}");
    }
    // Nine rollers: sin(pi / 9) / (pi / 9).
    let by_hand = (std::f64::consts::PI / 9.0).sin() / (std::f64::consts::PI / 9.0);
    assert!((sideways / ahead - by_hand).abs() < 1e-3, "{sideways}");
    let controller = &found.controller;
    let factor = controller.sideways_factor.as_ref().expect("a factor").value;
    assert!((factor - ahead / sideways).abs() < 1e-12);
    let lever_m = controller.lever_m.as_ref().expect("a lever").value;
    assert!((lever_m / found.parameters["lever_m"].value - ahead / turn).abs() < 1e-9);
    assert!(
        found.over_errors.expect("nine values") < 1.0,
        "{:?}",
        found.over_errors
    );
}

/// Centimetres in the place of metres are no robot.
#[test]
fn ends_in_another_unit_are_refused() {
    let file = assets().join("robots").join("mecanum4.urdf");
    let of = |x: f64| {
        let text = format!(
            "robot = {:?}\n[[measured]]\ndrive = {{ vx_m_s = 0.4, for_s = 5 }}\nx_m = {x}\n[[measured]]\n\
             drive = {{ omega_rad_s = 1.0, for_s = 3 }}\nheading_deg = 171.0\n",
            file.display().to_string()
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tape.toml");
        std::fs::write(&path, text).unwrap();
        let tape = Tape::load_within(&path, &FileAccess::anywhere())
            .unwrap()
            .unwrap();
        tape.fit().map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(of(1.97), Ok(()));
    assert!(
        of(197.0)
            .unwrap_err()
            .contains("further than a tape reaches")
    );
    assert!(
        of(19.7)
            .unwrap_err()
            .contains("but the robot's file has 0.05")
    );
}
