//! A fast turn on the spot, in both engines: the robot's turn per turn of its wheels.

use crate::oracle::case::{Case, Wheels, ramp, robot};
use crate::oracle::cases::twist;
use crate::oracle::course::Course;
use crate::oracle::engines::{Springs, in_ilon, on_springs};

/// Half a second of ramp, and a second and a half held.
fn turn(rate_rad_s: f64) -> Case {
    let target = ramp(twist(0.0, 0.0, rate_rad_s), 0.0, 0.5);
    Case::new("spin", robot("mecanum4"), 0.6, 1.5, move |t_s| {
        Wheels::Follow(target(t_s))
    })
}

/// Turns of the robot per turn of the wheels, after the ramp.
fn turned(course: &Course) -> f64 {
    let (from, to) = (course.at(0.7), course.end());
    let wheels = from.wheels_rad.iter().zip(&to.wheels_rad);
    let wheels_rad: f64 = wheels.map(|(from, to)| (to - from).abs()).sum();
    (to.heading_rad - from.heading_rad) / (0.25 * wheels_rad)
}

/// At 4.8 rad/s the robot turns by 0.21 % more than its rollers in contact give (docs/slip.md). If
/// that were an error of ilon, the robot on springs would turn less: both agree per wheel turn
/// within a quarter of it. Halving ilon's step changes 2e-4 of the ratio, four times the stiffness
/// 1e-4.
#[test]
fn a_fast_turn_on_the_spot_goes_as_far_as_on_springs() {
    for rate_rad_s in [1.2, 4.8] {
        let case = turn(rate_rad_s);
        let steps = [5e-4, 2.5e-4].map(|step_s| turned(&in_ilon(&case, step_s, None)));
        let springs = [5e6, 2e7].map(|k| turned(&on_springs(&case, Springs::of(k))));
        println!("{rate_rad_s}: ilon {steps:.6?}, springs {springs:.6?}");
        assert!(
            (steps[1] / springs[1] - 1.0).abs() < 5e-4,
            "{rate_rad_s}: {steps:?} {springs:?}"
        );
    }
}
