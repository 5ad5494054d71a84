//! Transients with slip.

use crate::oracle::case::{Case, TICK_S};
use crate::oracle::cases;
use crate::oracle::limit;

/// Asserts that ilon's course is the oracle's rigid limit within both uncertainties, which must be
/// less than 0.4 % of the path. The long slide of each case begins and ends in the same ticks of
/// 5 ms or in neighbouring ones, and has the same heat.
fn agree(case: &Case) {
    let (ilon, oracle) = (limit::ilon(case, 5e-4), limit::rigid(case));
    let arm_m = case.arm_m();
    let (way_m, within_m) = (oracle.course.way_m(arm_m), ilon.within_m + oracle.within_m);
    let apart_m = ilon.course.worst_m(&oracle.course, arm_m);
    let heats = [&ilon, &oracle].map(|known| known.course.end().sums.slip_j);
    println!(
        "{}: {:.3} mm apart on a way of {:.1} mm, {:.3} + {:.3} mm expected; heat {heats:.4?} J",
        case.name,
        1e3 * apart_m,
        1e3 * way_m,
        1e3 * ilon.within_m,
        1e3 * oracle.within_m,
    );
    assert!(
        within_m < 4e-3 * way_m,
        "nothing is known within {within_m} m"
    );
    assert!(apart_m < within_m);
    let slides = [&ilon, &oracle].map(|known| known.course.slide_s(0.02).expect("it slides"));
    println!("slides {slides:?} s");
    assert!((slides[0].0 - slides[1].0).abs() < 1.01 * TICK_S);
    assert!((slides[0].1 - slides[1].1).abs() < 1.01 * TICK_S);
    // The heat is mu N times the sliding path: it may differ by as much as the paths.
    assert!((heats[0] / heats[1] - 1.0).abs() < 5e-3);
}

#[test]
fn a_hard_diagonal_start_slides_as_far_as_rigid_contacts_let_it() {
    agree(&cases::hard_start_diagonal());
}

#[test]
#[ignore = "minutes: .ci/nightly"]
fn an_emergency_stop_out_of_an_arc_ends_where_rigid_contacts_let_it() {
    agree(&cases::stop_out_of_an_arc());
}

#[test]
#[ignore = "minutes: .ci/nightly"]
fn a_robot_on_three_held_wheels_is_pushed_as_far_as_rigid_contacts_let_it() {
    agree(&cases::push_volksbot());
}

#[test]
fn a_robot_on_four_held_wheels_is_pushed_as_far_as_rigid_contacts_let_it() {
    agree(&cases::push_mecanum());
}

/// On a nap at 20 degrees, with half the friction across it: three wheels slide each in its own
/// direction.
#[test]
#[ignore = "minutes: .ci/nightly"]
fn a_robot_on_held_wheels_is_pushed_over_a_nap_as_far_as_an_elliptical_cone_lets_it() {
    let mut case = cases::push_volksbot();
    case.name = "push 60 N, mu 0.6 and 0.3 across 20 deg".to_owned();
    case.nap = Some((20.0_f64.to_radians(), 0.5));
    agree(&case);
}

#[test]
fn a_hard_start_over_a_nap_slides_as_far_as_an_elliptical_cone_lets_it() {
    let mut case = cases::hard_start_diagonal();
    case.name = "hard start 4 m/s^2, mu 0.3 and 0.18 across 20 deg".to_owned();
    case.nap = Some((20.0_f64.to_radians(), 0.6));
    agree(&case);
}
