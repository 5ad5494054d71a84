//! Rollers with play along their axles, in both engines. The oracle moves a massless roller to the
//! balance of floor and stops, on springs, and puts it at its lower end while it is in the air.

use nalgebra::Vector3;

use crate::oracle::case::{Case, Shove, Wheels, ramp, robot};
use crate::oracle::cases::twist;
use crate::oracle::course::Course;
use crate::oracle::engines::{Springs, in_ilon, on_springs, on_treads};
use ilon_robot::Twist;

const PLAY_M: f64 = 5e-4;

/// Half a second of ramp and one of drive, with a force in N along the direction of motion from the
/// end of the ramp on.
fn drive(name: &str, play_m: f64, end: Twist, force_n: f64) -> Case {
    let mut robot = robot("mecanum4");
    for wheel in &mut robot.wheels {
        wheel.surface.axial_play_m = play_m;
    }
    let target = ramp(end, 0.0, 0.5);
    let mut case = Case::new(name, robot, 0.8, 1.5, move |t_s| {
        Wheels::Follow(target(t_s))
    });
    let along = Vector3::new(end.vx_m_s, end.vy_m_s, 0.0).normalize();
    case.shove = Some(Shove {
        force_in_world_n: force_n * along,
        from_s: 0.5,
        until_s: 1.5,
    });
    case
}

/// The change of the path by play is the same in both engines.
fn takes_alike(name: &str, end: Twist, force_n: f64) {
    let [case, tight] = [PLAY_M, 0.0].map(|play_m| drive(name, play_m, end, force_n));
    let arm_m = case.arm_m();
    let springs = [2e6, 8e6].map(|stiffness| on_springs(&case, Springs::of(stiffness)));
    let without = on_springs(&tight, Springs::of(8e6));
    let steps = [5e-4, 2.5e-4].map(|step_s| in_ilon(&case, step_s, None));
    let treads = on_treads(&case, 8e6, 2.5e-4);
    let rigid = in_ilon(&tight, 2.5e-4, None);
    let end = |course: &Course| course.end().position_m.norm();
    println!(
        "| {name} | {:.3} | {:.3} | {:.3} | {:.3}, {:.3} | {:.3}, {:.3} | {:.3} |",
        1e3 * end(&rigid),
        1e3 * end(&without),
        1e3 * end(&treads),
        1e3 * end(&steps[0]),
        1e3 * end(&steps[1]),
        1e3 * end(&springs[0]),
        1e3 * end(&springs[1]),
        1e3 * steps[1].worst_m(&springs[1], arm_m),
    );
    // The uncertainty is the change with springs of a quarter of the stiffness and twice the step,
    // plus a seventh of the play's effect: ilon resolves a roller's touch-down and the impact on a
    // stop with its step of a quarter of a millisecond, the oracle with one of 8 us.
    let taken_m = (end(&without) - end(&springs[1])).abs();
    let within_m = springs[0].worst_m(&springs[1], arm_m);
    let apart_m = treads.worst_m(&springs[1], arm_m);
    assert!(
        apart_m < within_m + taken_m / 7.0,
        "{name}: {apart_m} {within_m} {taken_m}"
    );
}

const AHEAD: Twist = Twist::new(0.2, 0.0, 0.0);
const LEFT: Twist = Twist::new(0.0, 0.2, 0.0);

#[test]
fn play_takes_of_a_way_ahead_held_back_what_it_takes_on_springs() {
    takes_alike("ahead, held back", AHEAD, -30.0);
}

#[test]
#[ignore = "minutes: .ci/nightly"]
fn play_takes_of_a_way_sideways_what_it_takes_on_springs() {
    takes_alike("sideways", LEFT, 0.0);
}

#[test]
#[ignore = "minutes: .ci/nightly"]
fn play_takes_of_a_way_sideways_pushed_what_it_takes_on_springs() {
    takes_alike("sideways, pushed", LEFT, 30.0);
}

#[test]
#[ignore = "minutes: all other ways"]
fn play_takes_of_all_other_ways_what_it_takes_on_springs() {
    takes_alike("ahead", AHEAD, 0.0);
    takes_alike("ahead, pushed", AHEAD, 30.0);
    takes_alike("back, held back", twist(-0.2, 0.0, 0.0), -30.0);
    takes_alike("sideways, held back", LEFT, -30.0);
}
