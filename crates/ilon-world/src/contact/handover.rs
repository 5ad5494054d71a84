//! Which of a wheel's rollers carries it, where several are near a plane.

use ilon_robot::Scale;
use nalgebra::Vector3;

use crate::contact::candidate::{Candidate, UPRIGHT};
use crate::contact::reaction::Part;
use crate::dynamics::LinkPose;
use crate::robot::roller::RollerState;

/// Leaves out the rollers of a wheel that have handed it over to another, which stands on the same plane and is nearer
/// to it.
///
/// Barrels that follow each other without a gap make an upright wheel round, and rigid: beyond its end a roller is higher
/// than the next one and carries nothing. But in the step of the hand-over both are within a micrometre of the ground, and
/// two that stick in one step rub against each other's way. A wheel that leans on the plane has several to stand on.
pub(super) fn leave_out_handed_over(
    found: &mut Vec<Candidate>,
    hub_axis: &Vector3<f64>,
    scale: &Scale,
) {
    let handed_over = |one: &Candidate, other: &Candidate| {
        let nearer = other.gap_m < one.gap_m || other.gap_m == one.gap_m && other.a < one.a;
        one.a != other.a
            && one.on_barrel
            && other.on_barrel
            && nearer
            && stand_on_one_plane(one, other, hub_axis, scale)
    };
    leave_out(found, handed_over);
}

/// Leaves out the rollers of a wheel whose outline is no circle that another roller keeps off the ground: one that stands on the
/// same plane and is nearer to it, now and at the end of the step.
///
/// In the step of a landing both stay, the roller that carries the wheel and the one that comes down. Else one carries it: the ends
/// of two neighbours can be equally low for degrees of a turn, and two that stick rub against each other's way. Of equals that one
/// stays which is nearer to straight down, as the contact kinematics has it.
pub(super) fn leave_out_higher(
    found: &mut Vec<Candidate>,
    hub: &LinkPose,
    (rollers, scale): (&[RollerState], &Scale),
) {
    /// What a robot leans or sags by decides nothing: below this, in wheel radii, two are equally low. 2 um for wheels of 50 mm.
    const EQUAL: f64 = 4e-5;
    let equal_m = EQUAL * scale.length_m;
    let axis = hub.axis();
    let below_hub_m = |place: &Candidate| match place.a.part {
        Part::Roller(_, roller) => {
            let from_hub_m = rollers[roller].center_m(hub) - hub.center_m;
            -from_hub_m.dot(&place.normal)
        }
        _ => f64::NEG_INFINITY,
    };
    let nearer_to_down = |one: &Candidate, other: &Candidate| {
        let (one_m, other_m) = (below_hub_m(one), below_hub_m(other));
        other_m > one_m || other_m == one_m && other.a < one.a
    };
    let higher = |one: &Candidate, other: &Candidate| {
        let lower = |of_one: f64, of_other: f64| {
            if (of_other - of_one).abs() < equal_m {
                nearer_to_down(one, other)
            } else {
                of_other < of_one
            }
        };
        one.a != other.a
            && one.on_barrel
            && other.on_barrel
            && lower(one.gap_m, other.gap_m)
            && lower(one.gap_ahead_m, other.gap_ahead_m)
            && stand_on_one_plane(one, other, &axis, scale)
    };
    leave_out(found, higher);
}

/// Whether two places of an upright wheel lie on one plane.
fn stand_on_one_plane(
    one: &Candidate,
    other: &Candidate,
    hub_axis: &Vector3<f64>,
    scale: &Scale,
) -> bool {
    /// Far above the rounding of a plane's places, and far below any step in a ground, in wheel radii.
    const ONE_PLANE: f64 = 2e-4;
    one.normal.dot(hub_axis).abs() < UPRIGHT
        && one.normal.dot(&other.normal) > 1.0 - 1e-6
        && one.normal.dot(&(other.place_m - one.place_m)).abs() < ONE_PLANE * scale.length_m
}

/// Leaves out the places that another outdoes. The best always stays, and leaving one out makes nobody else better.
fn leave_out(found: &mut Vec<Candidate>, outdone: impl Fn(&Candidate, &Candidate) -> bool) {
    let mut index = 0;
    while index < found.len() {
        let gone = found.iter().any(|other| outdone(&found[index], other));
        if gone {
            found.swap_remove(index);
        } else {
            index += 1;
        }
    }
}
