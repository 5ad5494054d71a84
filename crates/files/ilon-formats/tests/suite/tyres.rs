//! Wheels without rollers: recognised by how they can be driven, or named.

use ilon_formats::{LoadOptions, LoadRobot, TyreOptions};
use ilon_robot::{JointRole, Robot};

const SKID: &str = include_str!("../../../../../assets/robots/skid4.urdf");
const DIFFERENTIAL: &str = include_str!("../../../../../assets/robots/differential.urdf");
const SWERVE: &str = include_str!("../../../../../assets/robots/swerve4.urdf");
const TRICYCLE: &str = include_str!("../../../../../assets/robots/tricycle.urdf");

fn load(urdf: &str) -> Robot {
    Robot::from_urdf_str(urdf, "robot.urdf").expect("a robot on tyres")
}

fn names(robot: &Robot) -> Vec<&str> {
    robot
        .wheels
        .iter()
        .map(|wheel| wheel.name.as_str())
        .collect()
}

#[test]
fn wheels_that_a_plug_in_drives_as_plain_ones_roll_on_tyres() {
    let robot = load(SKID);
    assert_eq!(robot.wheels.len(), 4);
    for wheel in &robot.wheels {
        assert!(wheel.has_tyre() && wheel.is_round());
        assert!((wheel.rollers[0].length_m - 0.05).abs() < 1e-12);
        // All mass stays with the hub.
        assert!((wheel.hub.mass_kg - 1.0).abs() < 1e-12 && wheel.rollers[0].mass_kg == 0.0);
    }
    // Nothing says so without the plug-in.
    let silent = SKID.replace("diff_drive", "some_drive");
    let silent = silent.replace("skid_steer", "some_other");
    let error = Robot::from_urdf_str(&silent, "robot.urdf").unwrap_err();
    assert!(
        error.to_string().contains("4 wheels without rollers"),
        "{error}"
    );
    let mut options = LoadOptions::default();
    options.tyres = Some(TyreOptions::default());
    let loaded = Robot::from_urdf_str_with(&silent, "robot.urdf", &options).expect("asked for");
    assert_eq!(names(&loaded.robot), names(&robot));
}

#[test]
fn a_pair_of_wheels_rolls_on_tyres_beside_casters_that_swivel_freely() {
    let robot = load(DIFFERENTIAL);
    assert_eq!(names(&robot), ["left", "right"]);
    assert_eq!(robot.joints.len(), 4);
    assert!(
        robot
            .joints
            .iter()
            .all(|joint| joint.role == JointRole::Free)
    );
}

#[test]
fn steered_wheels_are_driven_and_their_upright_joints_are_servos() {
    let robot = load(SWERVE);
    assert_eq!(robot.wheels.len(), 4);
    for wheel in &robot.wheels {
        let joint = robot.steering_of(wheel).expect("steered");
        assert!(robot.joints[joint].name.ends_with("_steer"));
        assert!(wheel.motor.effort_n_m > 0.0);
    }
}

#[test]
fn of_wheels_of_which_only_some_have_a_torque_the_others_roll_along() {
    let robot = load(TRICYCLE);
    let efforts: Vec<f64> = robot
        .wheels
        .iter()
        .map(|wheel| wheel.motor.effort_n_m)
        .collect();
    assert_eq!(names(&robot), ["drive", "left", "right"]);
    assert_eq!(efforts, [6.0, 0.0, 0.0]);
}

/// A robot that speaks of mecanum wheels is none on tyres: it is asked for its rollers as before.
#[test]
fn what_calls_itself_mecanum_gets_no_tyres() {
    let urdf = SWERVE.replace("robot name=\"swerve4\"", "robot name=\"mecanum_base\"");
    let error = Robot::from_urdf_str(&urdf, "robot.urdf").unwrap_err();
    assert!(error.to_string().contains("steered wheels"), "{error}");
}

#[test]
fn a_tyre_that_is_none_is_refused_with_its_numbers() {
    for (width_m, shoulder_m) in [(0.0, 0.0), (0.03, 0.02), (0.3, 0.09), (-1.0, 0.0)] {
        let mut tyres = TyreOptions::default();
        tyres.width_m = Some(width_m);
        tyres.shoulder_radius_m = Some(shoulder_m);
        let mut options = LoadOptions::default();
        options.tyres = Some(tyres);
        let error = Robot::from_urdf_str_with(SKID, "robot.urdf", &options).unwrap_err();
        assert!(error.to_string().contains("tyre"), "{error}");
    }
}
