//! Driven joints: commands from a scenario's setpoints and from a program, and refused ones.

use std::path::Path;

use ilon_sim::robot::{JointKind, JointRole, Robot, Twist};
use ilon_sim::simulate::Limits;
use ilon_sim::{Error, JointCommand, Plant, Scenario, WheelCommand, load_robot, resolve};
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
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
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

/// A run begins at the first setpoint, passes half of a smooth motion in half of its time, and ends
/// at the last.
#[test]
fn an_arm_goes_through_its_setpoints() {
    let mut plant = plant(ARM).expect("a scenario");
    let hold = WheelCommand::Rates(&HOLD);
    // The arm turns about the vertical, so it does not sag; dry friction and the error of the
    // equilibrium are far smaller.
    assert!((position(&plant) - 0.2).abs() < 1e-6);
    plant.advance(hold, 0.35).expect("it goes");
    // The target moves at 3.75 rad/s; the joint's damping and dry friction delay it by some mrad.
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

/// A program's command replaces the setpoints; a snapshot restores everything to the bit.
#[test]
fn a_program_sends_a_joint_and_a_snapshot_brings_it_back() {
    let mut plant = plant(ARM).expect("a scenario");
    let hold = WheelCommand::Rates(&HOLD);
    plant.advance(hold, 0.3).expect("it goes");
    let to = |position| JointCommand::Position {
        position,
        rate: 0.0,
    };
    plant.command_joints(&[("arm", to(-0.5))]).expect("driven");
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
            .command_joints(&[(joint, to(at))])
            .unwrap_err()
            .to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test_case("[robot.joints.arn]\nrole = \"driven\"", "there is no joint `arn`"; "a joint that is not there")]
#[test_case("[robot.joints.front_left]\nrole = \"driven\"", "`front_left`"; "a wheel's joint")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\neffort_n = 3", "write `effort_n_m`"; "the effort of a slide")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\neffort_n_m = 0", "effort_n_m"; "no effort")]
#[test_case("[robot.joints.arm]\nsetpoints = [{ t_s = 0, position_rad = 0 }]", "setpoints but no servo"; "setpoints without a servo")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 1, position_rad = 0 }, { t_s = 1, position_rad = 1 }]", "not in order of time"; "times that do not increase")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0, position_m = 0 }]", "position_rad"; "the unit of a slide")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0 }]", "exactly one of"; "no position")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0, rate_rad_s = 0, torque_n_m = 1 }]", "exactly one of"; "a rate and a torque")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0, rate_rad_s = 0 }, { t_s = 1, position_rad = 1 }]", "exactly one of"; "a rate, then a position")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0, force_n = 1 }]", "torque_n_m"; "the force of a slide")]
#[test_case("[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0, torque_n_m = nan }]", "finite"; "a torque that is no number")]
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

/// The lift with 4 kg on a damper of 5 N s/m with 1 N of dry friction.
fn lift(setpoints: &str) -> Plant {
    let joints = format!("[robot.joints.lift]\nrole = \"driven\"\nsetpoints = [{setpoints}]");
    plant(&joints).expect("a scenario")
}

/// A force F in place of a servo: m x'' = F - m g - f - c x' from the lower stop.
#[test]
fn a_force_lifts_what_newton_says() {
    let (mass_kg, friction_n, damping_n_s_m, force_n) = (4.0, 1.0, 5.0, 45.0);
    let mut plant = lift("{ t_s = 0, force_n = 45 }");
    plant
        .advance(WheelCommand::Rates(&HOLD), 0.5)
        .expect("it goes");
    let net_n: f64 = force_n - mass_kg * 9.81 - friction_n;
    let time_s = mass_kg / damping_n_s_m;
    let decayed = 1.0 - (-0.5 / time_s).exp();
    let expected_m = net_n / damping_n_s_m * (0.5 - time_s * decayed);
    // The ground deflects by micrometres, and the first step only holds it.
    let found_m = position(&plant);
    assert!(
        (found_m - expected_m).abs() < 5e-3 * expected_m,
        "{found_m} {expected_m}"
    );
    // Never more than its effort: 200 N cannot hold what 1e6 N could.
    plant
        .command_joints(&[("lift", JointCommand::Effort(1e6))])
        .expect("a force");
    let before = plant.world().robot().joint_rates()[0];
    plant
        .advance(WheelCommand::Rates(&HOLD), 0.02)
        .expect("it goes");
    let gained = plant.world().robot().joint_rates()[0] - before;
    let most = (200.0 - mass_kg * 9.81) / mass_kg * 0.02;
    assert!(gained < most && gained > 0.9 * most, "{gained} {most}");
}

/// A servo at a rate u sags by its load over its stiffness, (m g + f + c u) / K, and no more with
/// time: x = u t minus that. K = m (2 pi 10 Hz)^2.
#[test]
fn a_servo_follows_a_rate_and_sags_no_further() {
    let mut plant = lift("{ t_s = 0, rate_m_s = 0.2 }");
    let stiffness_n_m = 4.0 * std::f64::consts::TAU.powi(2) * 100.0;
    let sag_m = (4.0 * 9.81 + 1.0 + 5.0 * 0.2) / stiffness_n_m;
    plant
        .advance(WheelCommand::Rates(&HOLD), 1.0)
        .expect("it goes");
    let (found_m, expected_m) = (position(&plant), 0.2 - sag_m);
    assert!(
        (found_m - expected_m).abs() < 2e-5,
        "{found_m} {expected_m}"
    );
    // Down again, and not beyond either limit: the target stays at the stop, so that it reverses at
    // once.
    plant
        .command_joints(&[("lift", JointCommand::Rate(-0.3))])
        .expect("a rate");
    plant
        .advance(WheelCommand::Rates(&HOLD), 3.0)
        .expect("it goes");
    assert!(position(&plant).abs() < 1e-3);
    plant
        .command_joints(&[("lift", JointCommand::Rate(0.2))])
        .expect("a rate");
    plant
        .advance(WheelCommand::Rates(&HOLD), 0.5)
        .expect("it goes");
    let found_m = position(&plant);
    assert!((found_m - (0.1 - sag_m)).abs() < 1e-4, "{found_m}");
}

/// A blocked joint holds its target back: after a second against an effort that cannot lift, the
/// arm's target leads by no more than the effort can hold, and a rate the other way reverses it at
/// once.
#[test]
fn a_target_does_not_run_away_from_a_joint_that_is_held_back() {
    let joints = "[robot.joints.lift]\nrole = \"driven\"\neffort_n = 20\nsetpoints = [{ t_s = 0, rate_m_s = 0.2 }]";
    let mut plant = plant(joints).expect("a scenario");
    plant
        .advance(WheelCommand::Rates(&HOLD), 1.0)
        .expect("it goes");
    assert!(position(&plant).abs() < 1e-3);
    let ahead_m = 20.0 / (4.0 * std::f64::consts::TAU.powi(2) * 100.0);
    let target_m = plant
        .world()
        .robot()
        .joint_targets()
        .next()
        .expect("a joint");
    assert!((target_m - ahead_m).abs() < 2e-4, "{target_m} {ahead_m}");
}

/// A scenario in which the arm is held at an angle, under a wheel law.
fn held_at(target_rad: f64, law: &str) -> Scenario {
    let joints = format!("[robot.joints.arm]\nrole = \"driven\"\ntarget_rad = {target_rad}");
    let joints = format!("{joints}\n\n[wheel_loop]\nlaw = \"{law}\"");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    Scenario::from_toml(&text(&joints), "joints", folder).expect("a scenario")
}

/// The robot whose arm is at zero where that of the file is at 1.2 rad.
fn made_swung_out() -> Robot {
    let robot = load_robot(&held_at(0.0, "pid")).expect("a robot");
    let mut made = robot.posed(&[1.2]);
    if let JointRole::Driven(servo) = &mut made.joints[0].role {
        servo.target = 0.0;
    }
    made
}

/// A robot with its arm at an angle behaves like one whose arm was built there: gains, masses,
/// kinematics and loads of every law are those of the pose.
#[test_case("pid")]
#[test_case("computed_torque")]
#[test_case("prioritised_torque")]
#[test_case("passive")]
fn a_robot_goes_as_one_that_was_made_in_its_pose(law: &str) {
    let goes = |scenario: &Scenario, robot: &Robot| {
        let resolved = resolve(scenario, robot).expect("a scenario");
        let mut plant = Plant::new(&resolved, robot).expect("it stands");
        for rate_rad_s in [2.0, 4.0, 6.0, 6.0, 6.0] {
            let rates_rad_s = [rate_rad_s, 0.5 * rate_rad_s, rate_rad_s, 0.5 * rate_rad_s];
            plant
                .advance(WheelCommand::Rates(&rates_rad_s), 0.06)
                .expect("it goes");
        }
        plant.truth().pose
    };
    let robot = load_robot(&held_at(1.2, law)).expect("a robot");
    let (swung, made) = (
        goes(&held_at(1.2, law), &robot),
        goes(&held_at(0.0, law), &made_swung_out()),
    );
    assert!(swung.x_m.hypot(swung.y_m) > 0.02, "{swung:?}");
    // The same system in other numbers: rounding, and the tolerance of the equilibrium.
    let off_m = (swung.position_m() - made.position_m()).norm();
    let off_rad = (swung.heading_rad - made.heading_rad).abs();
    assert!(off_m < 1e-6 && off_rad < 1e-6, "{swung:?} {made:?}");
}

/// A robot whose arm has swung out at rest continues like one whose arm was out from the beginning:
/// the law has followed.
#[test_case("computed_torque")]
#[test_case("prioritised_torque")]
fn a_law_follows_joints_that_move(law: &str) {
    let goes = |joints: &str| {
        let mut plant =
            plant(&format!("{joints}\n[wheel_loop]\nlaw = \"{law}\"")).expect("it stands");
        plant
            .advance(WheelCommand::Rates(&HOLD), 1.5)
            .expect("it stands");
        let from = plant.truth().pose;
        for step in 1..=30 {
            let rate_rad_s = 0.3 * f64::from(step);
            let rates_rad_s = [rate_rad_s, 0.5 * rate_rad_s, rate_rad_s, 0.5 * rate_rad_s];
            plant
                .advance(WheelCommand::Rates(&rates_rad_s), 0.01)
                .expect("it goes");
        }
        from.displacement_to(&plant.truth().pose)
    };
    let (followed, started) = (
        goes(ARM),
        goes("[robot.joints.arm]\nrole = \"driven\"\ntarget_rad = 1.2"),
    );
    assert!(started.vx_m_s > 0.02, "{started:?}");
    // The arm's recoil leaves each wheel at another angle of its rollers. A law that did not follow
    // would be off by 0.1 mm and 4 mrad.
    let off = [
        followed.vx_m_s - started.vx_m_s,
        followed.vy_m_s - started.vy_m_s,
        followed.omega_rad_s - started.omega_rad_s,
    ];
    assert!(off.iter().all(|off| off.abs() < 3e-6), "{off:?}");
}

/// Guidance and odometry use the start positions of the servos: wheels moved out by 50 mm turn the
/// robot by their own places, like the arm l + w of the mecanum matrix.
#[test]
fn kinematics_are_those_of_where_the_joints_start() {
    let rates_at = |out_m: f64| {
        let mut scenario = held_at(0.0, "pid");
        scenario.robot.joints.clear();
        let mut robot = load_robot(&held_at(0.0, "pid")).expect("a robot");
        let arm = robot.joints.remove(0);
        for side in [1.0, -1.0] {
            let mut slide = arm.clone();
            slide.name = format!("slide {side}");
            slide.kind = JointKind::Slides;
            // Its axis z along y, to the left or to the right.
            let turn = nalgebra::Vector3::x() * (-side * std::f64::consts::FRAC_PI_2);
            slide.body_from_joint = nalgebra::Isometry3::rotation(turn);
            if let JointRole::Driven(servo) = &mut slide.role {
                servo.target = out_m;
            }
            robot.joints.push(slide);
        }
        for wheel in &mut robot.wheels {
            wheel.carrier = Some(usize::from(wheel.position_m().y < 0.0));
        }
        let arm_m = robot.wheels[0].position_m().xy().lp_norm(1);
        let resolved = resolve(&scenario, &robot).expect("a scenario");
        let plant = Plant::new(&resolved, &robot).expect("it stands");
        let mut rates_rad_s = [0.0; 4];
        let turn = Twist::new(0.0, 0.0, 1.0);
        plant.kinematics().wheel_rates(turn, &mut rates_rad_s);
        (rates_rad_s, arm_m)
    };
    let ((before, arm_m), (after, _)) = (rates_at(0.0), rates_at(0.05));
    for (before, after) in before.iter().zip(after) {
        let expected = before * (arm_m + 0.05) / arm_m;
        assert!((after / expected - 1.0).abs() < 1e-9, "{after} {expected}");
    }
}

/// The limits of grip are those of the pose: a robot with its arm swung out has the limits of one
/// built like that.
#[test]
fn limits_are_those_of_where_the_joints_start() {
    let limits = |target_rad: f64, robot: &Robot| {
        Limits::of(&held_at(target_rad, "pid"), robot).expect("limits")
    };
    let robot = |target_rad: f64| load_robot(&held_at(target_rad, "pid")).expect("a robot");
    let (ahead, out) = (limits(0.0, &robot(0.0)), limits(1.2, &robot(1.2)));
    let made = limits(0.0, &made_swung_out());
    for (out, made) in out.rows.iter().zip(&made.rows) {
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

/// A motion between the limits of grip with the arm ahead and with the arm out is reported before
/// the run, if the arm will have moved.
#[test]
fn a_motion_is_judged_with_the_arm_where_its_setpoints_send_it() {
    let ahead_m_s2 = |target_rad: f64| {
        let robot = load_robot(&held_at(target_rad, "pid")).expect("a robot");
        let limits = Limits::of(&held_at(target_rad, "pid"), &robot).expect("limits");
        limits.rows[0].speeding_up.largest
    };
    let (before, after) = (ahead_m_s2(0.0), ahead_m_s2(1.2));
    assert!(after < 0.98 * before, "{after} of {before}");
    let ramp_s = 0.5 / (0.5 * (before + after));
    // With the arm at zero all along the ramp, which begins at 1 s, and out from its beginning on.
    let is_remarked = |goes_s: f64| {
        let text = text(&format!(
            "[robot.joints.arm]\nrole = \"driven\"\n\
             setpoints = [{{ t_s = {goes_s}, position_rad = 0 }}, {{ t_s = {}, position_rad = 1.2 }}]",
            goes_s + 0.1
        ));
        let ramp = format!("vx_m_s = 0.5\nramp_s = {ramp_s}\n");
        let text = text.replace("vx_m_s = 0\n", &ramp);
        let text = text.replace("duration_s = 1", "duration_s = 1.5");
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
        let scenario = Scenario::from_toml(&text, "joints", folder).expect("a scenario");
        let robot = load_robot(&scenario).expect("a robot");
        let resolved = resolve(&scenario, &robot).expect("it can be run");
        let mut said = resolved.warnings().iter();
        said.any(|line| line.contains("the motion is too fast"))
    };
    assert!(!is_remarked(1.0 + 1.1 * ramp_s) && is_remarked(0.5));
}
