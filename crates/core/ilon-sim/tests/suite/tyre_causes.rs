//! What casters and steering do to a robot on tyres: the run minus the run without.

use std::path::Path;

use ilon_sim::robot::{JointRole, Robot};
use ilon_sim::trace::{Summary, effects};
use ilon_sim::{Causes, Run, Scenario, Simulation, load_robot};
use test_case::test_case;

/// With a step and loops that do not depend on the robot.
fn scenario(robot: &str, motion: &str) -> Scenario {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!(
        "robot.file = \"{robot}.urdf\"\n{motion}\n\
         run = {{ duration_s = 2, physics_dt_s = 2e-3 }}\n\
         wheel_loop = {{ proportional_n_m_s = 0.3, integral_n_m = 1.0 }}"
    );
    Scenario::from_toml(&text, "tyre_causes", folder).expect("a scenario")
}

fn explained(scenario: &Scenario) -> Run {
    let simulation = Simulation::new(scenario).expect("it drives");
    simulation.explaining(Causes::All).run()
}

const ARC_AND_BACK: &str = "twist = { vx_m_s = 0.3, omega_rad_s = 0.8, rest_s = 0, ramp_s = 0.2, \
                            schedule = [{ from_s = 1, vx_m_s = -0.3, omega_rad_s = 0 }] }";
const AHEAD: &str = "twist = { vx_m_s = 0.3, rest_s = 0, ramp_s = 0.2 }";
const THEN_LEFT: &str = "twist = { vx_m_s = 0.5, rest_s = 0, ramp_s = 0.1, \
                         schedule = [{ from_s = 1, vx_m_s = 0, vy_m_s = 0.5 }] }";

/// On feet without friction in place of its casters.
fn on_feet(robot: &mut Robot) {
    for joint in robot.caster_joints() {
        for shape in &mut robot.joints[joint].body.collisions {
            shape.friction = Some(0.0);
        }
    }
}

/// With modules whose servos have no limit, and swing once in four steps, critically damped.
fn at_once(robot: &mut Robot) {
    let rate_rad_s = std::f64::consts::TAU / (4.0 * 2e-3);
    for index in 0..robot.joints.len() {
        let inertia = robot.inertia_on_joint(index);
        if let JointRole::Driven(servo) = &mut robot.joints[index].role {
            (servo.effort, servo.rate_limit) = (f64::INFINITY, f64::INFINITY);
            servo.stiffness = inertia * rate_rad_s.powi(2);
            servo.damping = 2.0 * inertia * rate_rad_s;
        }
    }
}

/// Casters that turn over push the robot aside, and modules that turn from ahead to the left leave
/// it off; where casters trail and modules stand there is nothing to tell.
#[test_case("differential", ARC_AND_BACK, "casters", on_feet, true)]
#[test_case("swerve4", THEN_LEFT, "steering", at_once, true)]
#[test_case("swerve4", AHEAD, "steering", at_once, false)]
fn casters_and_steering_do_what_the_run_without_them_lacks(
    robot: &str,
    motion: &str,
    cause: &str,
    change: fn(&mut Robot),
    differs: bool,
) {
    let scenario = scenario(robot, motion);
    let found = explained(&scenario);
    let summary = &found.summary;
    let moved = summary.effects.get(cause, effects::APART_M);
    assert_eq!(moved.map(|moved| moved.differs), Some(differs), "{moved:?}");

    let mut without = load_robot(&scenario).expect("shipped");
    change(&mut without);
    let without = Simulation::with_robot(&scenario, &without).expect("it drives");
    is_without(summary, cause, &without.run().summary);
}

/// A module that a target holds is a cause: without it the robot ends where it does with that
/// module steered.
#[test]
fn a_module_that_is_held_does_what_the_run_with_it_steered_lacks() {
    let held = "robot.joints.front_left_steer = { role = \"driven\", target_rad = 0.2 }";
    let found = explained(&scenario("swerve4", &format!("{held}\n{THEN_LEFT}")));
    let cause = "joints.front_left_steer";
    let moved = found.summary.effects.get(cause, effects::APART_M);
    assert_eq!(moved.map(|moved| moved.differs), Some(true), "{moved:?}");
    let without = Simulation::new(&scenario("swerve4", THEN_LEFT)).expect("it drives");
    is_without(&found.summary, cause, &without.run().summary);
}

/// The run without a cause ends where that by hand does.
fn is_without(summary: &Summary, cause: &str, without: &Summary) {
    for (key, with, without) in [
        ("end_x_m", summary.end_x_m, without.end_x_m),
        ("end_y_m", summary.end_y_m, without.end_y_m),
    ] {
        let effect = summary.effects.get(cause, key).expect("an effect");
        let off = [(effect.with, with), (effect.without, without)]
            .map(|(told, by_hand)| told.zip(by_hand).map(|(a, b)| (a - b).abs()));
        assert!(
            off.iter().all(|off| off.is_some_and(|off| off < 1e-9)),
            "{key}: {effect:?}, {with:?} and {without:?} by hand"
        );
    }
}

/// Holding casters or modules where they stand is no cause of anything: a robot does not drive so.
#[test_case("differential", ARC_AND_BACK, "casters")]
#[test_case("swerve4", THEN_LEFT, "steering")]
fn casters_and_modules_are_not_held(robot: &str, motion: &str, cause: &str) {
    let found = explained(&scenario(robot, motion));
    let causes = effects::of_causes(&found.summary, &found.trace.header);
    let keys: Vec<&str> = causes
        .iter()
        .filter_map(|one| one.cause.map(|of| of.key.as_str()))
        .collect();
    assert!(keys.contains(&cause), "{keys:?}");
    assert!(
        !keys.iter().any(|key| key.starts_with("joints")),
        "{keys:?}"
    );
    assert!(!keys.contains(&"geometry"), "{keys:?}");
}

/// A tricycle on a slope whose motor never gives all it could: without its limits the run is bit by
/// bit the same, for the wheels behind have no motor then either.
#[test]
fn wheels_that_no_motor_drives_get_none_with_its_limits_removed() {
    let motion = "twist = { vx_m_s = 0.3, omega_rad_s = 0.4 }\n\
                  world.floor = { slope_deg = -4, friction = 0.4 }";
    let found = explained(&scenario("tricycle", motion));
    let causes = effects::of_causes(&found.summary, &found.trace.header);
    let motors = causes
        .iter()
        .find(|one| one.cause.is_some_and(|of| of.key == "motors"))
        .expect("it has limits");
    assert_eq!((motors.apart.most_m, motors.apart.most_rad), (0.0, 0.0));
}

const ARC: &str = "twist = { vx_m_s = 0.3, omega_rad_s = 0.6, rest_s = 0, ramp_s = 0.2 }";

/// A robot that hardly slides goes where it goes without sliding, within the millimetres of a
/// little slip, or of the kick of casters that turn over; the run without loses next to nothing to
/// sliding. (Of tyres with their width grip of 100 was a brake on every turn: 0.5 to 1.6 m were "by
/// sliding".)
#[test_case("differential", ARC_AND_BACK, 0.03)]
#[test_case("tricycle", ARC, 0.01)]
fn without_sliding_tyres_still_turn(robot: &str, motion: &str, most_m: f64) {
    let found = explained(&scenario(robot, motion));
    let effect = |key: &str| {
        let effect = found.summary.effects.get("sliding", key);
        effect.expect("sliding is a cause")
    };
    let apart_m = effect(effects::APART_M).with.expect("a distance");
    assert!(apart_m < most_m, "{apart_m}");
    let slip_j = effect("slip_energy_j").without.expect("an energy");
    let with_j = found.summary.slip_energy_j.expect("an energy");
    assert!(slip_j < 0.05 * with_j, "{slip_j} J instead of {with_j} J");
}
