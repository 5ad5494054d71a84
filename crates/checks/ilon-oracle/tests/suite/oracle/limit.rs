//! The limits of both engines' courses, and their uncertainty.
//!
//! **The oracle** tends to rigid contacts as its springs stiffen. If a course depends on the
//! stiffness, it does so through hand-overs: two rollers of a wheel touch at once while one is
//! deeper than the other by less than the sag d = N / k. A roller past its end recedes from the
//! wheel's circle with the square of the angle, so that both touch over an angle that grows with
//! the root of d. The distance to the limit then falls as 1 / sqrt(k): four times the stiffness
//! halves it, and the limit is as far beyond the stiffer course as that is beyond the softer one.
//! Courses without such dependence fall as 1 / k; the limit is then nearer. So the limit is known
//! within that distance at worst.
//!
//! **ilon** has two numerical settings. Its error falls with the step, with a measured order of 0.6
//! to 1.1: the error after halving is at most 1 / (2^0.6 - 1) = 1.94 times the change by halving.
//! The stiffness of its contacts should have no effect: the change by halving it counts as
//! uncertainty.

use ilon_robot::Scale;

use crate::oracle::case::Case;
use crate::oracle::course::Course;
use crate::oracle::engines::{Springs, in_ilon, on_springs};

/// A course and its uncertainty.
pub struct Known {
    pub course: Course,
    pub within_m: f64,
}

/// The softer of the two stiffnesses that the limit is extrapolated from, in N/m; the other is four
/// times as stiff.
pub const SOFTER_N_M: f64 = 8e7;

/// The limit of rigid contacts.
pub fn rigid(case: &Case) -> Known {
    let softer = on_springs(case, Springs::of(SOFTER_N_M));
    let stiffer = on_springs(case, Springs::of(4.0 * SOFTER_N_M));
    let course = stiffer.beyond(&softer);
    let within_m = course.worst_m(&stiffer, case.arm_m());
    Known { course, within_m }
}

/// ilon with half of `step_s`, at its default contact stiffness.
pub fn ilon(case: &Case, step_s: f64) -> Known {
    let gravity_m_s2 = ilon_world::Settings::default().gravity_m_s2;
    let usual_n_m = ilon_world::contact_stiffness_n_m(&Scale::of(&case.robot, gravity_m_s2));
    let coarse = in_ilon(case, step_s, None);
    let course = in_ilon(case, 0.5 * step_s, None);
    let softer = in_ilon(case, 0.5 * step_s, Some(0.5 * usual_n_m));
    let arm_m = case.arm_m();
    let left = 1.0 / (2.0_f64.powf(0.6) - 1.0);
    let within_m = left * course.worst_m(&coarse, arm_m) + course.worst_m(&softer, arm_m);
    Known { course, within_m }
}
