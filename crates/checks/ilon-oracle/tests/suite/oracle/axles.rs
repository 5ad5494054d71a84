//! Rollers on bushings, in both engines: axle friction proportional to the load slows a robot that
//! coasts sideways or diagonally, but not one that coasts ahead.

use ilon_robot::{Joint, Twist};

use crate::oracle::case::{Case, Wheels, ramp, robot};
use crate::oracle::cases::twist;
use crate::oracle::course::Course;
use crate::oracle::engines::{Springs, in_ilon, on_springs};

/// When the wheels become free, in seconds.
const FREE_FROM_S: f64 = 0.6;

/// Up to a twist within 0.4 s; from 0.6 s on the wheels are free. Rollers turn on dry bushings of
/// 0.15 of their radius; nothing else has losses.
fn coasting(name: &str, friction: f64, from: Twist) -> Case {
    let mut robot = robot("mecanum4");
    for wheel in &mut robot.wheels {
        wheel.joint = Joint::default();
        wheel.surface.axle_friction = friction;
        wheel.surface.axle_radius_m = 0.15 * wheel.rollers[0].radius_m;
        for roller in &mut wheel.rollers {
            roller.joint = Joint::default();
        }
    }
    let target = ramp(from, 0.1, 0.4);
    Case::new(name, robot, 0.8, 1.4, move |t_s| {
        if t_s < FREE_FROM_S {
            Wheels::Follow(target(t_s))
        } else {
            Wheels::Free
        }
    })
}

/// The mean deceleration over 0.5 s of coasting, in m/s^2.
fn slows_m_s2(course: &Course) -> f64 {
    let way_m = |from_s: f64, until_s: f64| {
        (course.at(until_s).position_m - course.at(from_s).position_m).norm()
    };
    // From the paths over two periods of a tenth of a second, half a second apart.
    (way_m(0.7, 0.8) - way_m(1.2, 1.3)) / (0.1 * 0.5)
}

/// The tolerance is the change in both engines with springs of a quarter of the stiffness and twice
/// the step, plus a hundredth of the bushings' effect.
#[test]
#[ignore = "minutes: .ci/nightly"]
fn bushings_slow_a_robot_alike_in_both_engines() {
    let mut slowed = Vec::new();
    for (name, from) in [
        ("ahead", twist(0.5, 0.0, 0.0)),
        ("sideways", twist(0.0, 0.5, 0.0)),
        ("slantwise", twist(0.35, 0.35, 0.0)),
    ] {
        let case = coasting(name, 0.2, from);
        let arm_m = case.arm_m();
        let springs = [2e6, 8e6].map(|stiffness| on_springs(&case, Springs::of(stiffness)));
        let steps = [5e-4, 2.5e-4].map(|step_s| in_ilon(&case, step_s, None));
        let without = on_springs(&coasting(name, 0.0, from), Springs::of(8e6));
        let taken_m = (without.end().position_m - springs[1].end().position_m).norm();
        let within_m = springs[0].worst_m(&springs[1], arm_m) + steps[0].worst_m(&steps[1], arm_m);
        let apart_m = steps[1].worst_m(&springs[1], arm_m);
        let heats = [&steps[1], &springs[1]].map(|course| course.end().sums.bearings_j);
        let slows = [&steps[1], &springs[1]].map(slows_m_s2);
        println!(
            "{name}: {apart_m:.6} m apart, {within_m:.6} m known, {taken_m:.4} m taken; heats {heats:.5?} J, slows {slows:.4?} m/s^2"
        );
        assert!(apart_m < within_m + 0.01 * taken_m, "{name}");
        slowed.push((slows, heats));
    }
    // A drag of sqrt(2) mu a / r of the weight sideways. Rollers are up to a fifth thinner towards
    // their ends, and spin faster there; the inertia of wheels and rollers adds 3 % to the mass.
    let expected = 2.0_f64.sqrt() * 0.2 * 0.15 * 9.81;
    let ([ilon, oracle], heats) = slowed[1];
    assert!((ilon / oracle - 1.0).abs() < 0.01, "{ilon} {oracle}");
    assert!((heats[0] / heats[1] - 1.0).abs() < 0.01, "{heats:?}");
    assert!(
        (0.96..1.2).contains(&(ilon / expected)),
        "{ilon} {expected}"
    );
}
