//! Joints that servos drive: where a scenario's setpoints and a program send them, and what is refused.

use std::path::Path;

use ilon_sim::{Error, Plant, Scenario, WheelCommand};
use test_case::test_case;

const HOLD: [f64; 4] = [0.0; 4];

fn text(joints: &str) -> String {
    format!(
        r#"
[robot]
file = "mecanum4_arm.urdf"
wheels = {{ rollers = 9, roller_radius_m = 0.012, roller_mass_kg = 0.01, damping_n_m_s = 1e-6, gamma.x_deg = 45 }}

{joints}

[twist]
vx_m_s = 0

[run]
duration_s = 1
"#
    )
}

fn plant(joints: &str) -> Result<Plant, Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/robots");
    Plant::of_scenario(&Scenario::from_toml(&text(joints), "joints", folder)?)
}

const ARM: &str = r#"
[robot.joints.arm]
role = "driven"
setpoints = [{ t_s = 0.1, position_rad = 0.2 }, { t_s = 0.6, position_rad = 1.2 }]
"#;

fn position(plant: &Plant) -> f64 {
    plant.world().robot().joint_positions()[0]
}

/// A run begins at the first setpoint, passes half of a smooth way in half of its time, and ends at the last.
#[test]
fn an_arm_goes_through_its_setpoints() {
    let mut plant = plant(ARM).expect("a scenario");
    let hold = WheelCommand::Rates(&HOLD);
    // The arm turns about the vertical, so nothing makes it sag; dry friction and what is left of equilibrium are far smaller.
    assert!((position(&plant) - 0.2).abs() < 1e-6);
    plant.advance(hold, 0.35).expect("it goes");
    // The target moves at 3.75 rad/s, damping of the joint and its dry friction hold it back by some mrad.
    assert!(
        (position(&plant) - 0.7).abs() < 0.01,
        "{}",
        position(&plant)
    );
    plant.advance(hold, 0.65).expect("it goes");
    assert!(
        (position(&plant) - 1.2).abs() < 2e-3,
        "{}",
        position(&plant)
    );
}

/// A program sends the joint elsewhere, and the setpoints no longer hold; a snapshot brings all back to the bit.
#[test]
fn a_program_sends_a_joint_and_a_snapshot_brings_it_back() {
    let mut plant = plant(ARM).expect("a scenario");
    let hold = WheelCommand::Rates(&HOLD);
    plant.advance(hold, 0.3).expect("it goes");
    plant.set_joint_target("arm", -0.5, 0.0).expect("driven");
    plant.advance(hold, 0.1).expect("it goes");
    let snapshot = plant.snapshot();
    plant.advance(hold, 1.0).expect("it goes");
    let (first, first_truth) = (position(&plant), plant.truth());
    assert!((first + 0.5).abs() < 2e-3, "{first}");
    plant.restore(&snapshot).expect("its own");
    plant.advance(hold, 1.0).expect("it goes");
    assert_eq!((position(&plant), plant.truth()), (first, first_truth));
    plant.reset(0, plant.truth().pose).expect("it stands");
    assert!((position(&plant) - 0.2).abs() < 1e-6);
    for (joint, at, words) in [
        ("arn", 0.1, "no joint `arn`"),
        ("lift", 0.1, "no joint `lift`"),
        ("arm", 3.0, "its limits are -2.6 and 2.6"),
        ("arm", f64::NAN, "finite"),
    ] {
        let error = plant
            .set_joint_target(joint, at, 0.0)
            .unwrap_err()
            .to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test_case("[robot.joints.arn]\nrole = \"driven\"", "there is no joint `arn`"; "a joint that is not there")]
#[test_case("[robot.joints.front_left]\nrole = \"driven\"", "`front_left`"; "a wheel's joint")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\neffort_n = 3", "write `effort_n_m`"; "the effort of a slide")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\neffort_n_m = 0", "effort_n_m"; "no effort")]
#[test_case("[robot.joints.arm]\nsetpoints = [{ t_s = 0, position_rad = 0 }]", "setpoints and no servo"; "setpoints without a servo")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 1, position_rad = 0 }, { t_s = 1, position_rad = 1 }]", "go back in time"; "times that do not grow")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0, position_m = 0 }]", "position_rad"; "the unit of a slide")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0 }]", "one position"; "no position")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0, position_rad = 0 }, { t_s = 1, position_rad = 3 }]", "beyond its limits"; "a setpoint beyond the limits")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0, position_rad = 3 }]", "beyond its limits"; "a first setpoint beyond the limits")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\ntarget_rad = 0.1\nsetpoints = [{ t_s = 0, position_rad = 0.1 }]", "leave one of the two out"; "a target and setpoints")]
fn what_no_servo_can_do_is_refused_in_words(joints: &str, words: &str) {
    let Err(error) = plant(joints) else {
        panic!("not refused");
    };
    let error = format!("{error} {error:?}");
    assert!(error.contains(words), "{error}");
}

/// What grip allows is that of the pose: with its arm swung out a robot is limited as one whose arm was made so.
#[test]
fn limits_are_those_of_where_the_joints_start() {
    let scenario = |target_rad: f64| {
        let joints = format!("[robot.joints.arm]\nrole = \"driven\"\ntarget_rad = {target_rad}");
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/robots");
        Scenario::from_toml(&text(&joints), "joints", folder).expect("a scenario")
    };
    let robot = |target_rad: f64| ilon_sim::load_robot(&scenario(target_rad)).expect("a robot");
    let limits = |target_rad: f64, robot: &ilon_sim::robot::Robot| {
        ilon_sim::simulate::Limits::of(&scenario(target_rad), robot).expect("limits")
    };
    let (ahead, out) = (limits(0.0, &robot(0.0)), limits(1.2, &robot(1.2)));
    // The same robot with its arm where it is at 1.2 rad, and the servo's zero there.
    let mut made = robot(0.0).posed(&[1.2]);
    if let ilon_sim::robot::JointRole::Driven(servo) = &mut made.joints[0].role {
        servo.target = 0.0;
    }
    for (out, made) in out.rows.iter().zip(&limits(0.0, &made).rows) {
        let (out, made) = (&out.speeding_up, &made.speeding_up);
        assert!(
            (out.largest / made.largest - 1.0).abs() < 1e-9,
            "{out:?} {made:?}"
        );
        assert_eq!(out.wheel, made.wheel);
    }
    let changed = ahead.rows.iter().zip(&out.rows);
    let changed = changed.map(|(a, b)| (a.speeding_up.largest / b.speeding_up.largest - 1.0).abs());
    assert!(changed.fold(0.0, f64::max) > 0.01);
}
