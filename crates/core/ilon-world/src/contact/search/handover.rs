//! Selects which of a wheel's rollers carries it if several are near a plane.

use ilon_robot::Scale;
use nalgebra::Vector3;

use crate::contact::reactions::reaction::Part;
use crate::contact::search::candidate::{Candidate, UPRIGHT};
use crate::dynamics::LinkPose;
use crate::robot::roller::RollerState;

/// Removes the rollers of a wheel that have handed it over to another one, which is on the same
/// plane and nearer to it.
///
/// Barrels that follow each other without a gap make an upright wheel round and rigid: beyond its
/// end a roller is higher than the next one and carries nothing. But in the step of the hand-over
/// both are within a micrometre of the ground, and two that stick in one step obstruct each other.
/// A wheel that is tilted against the plane may stand on several.
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

/// Removes the rollers of a non-circular wheel that are kept off the ground by another roller: one
/// on the same plane and nearer to it, now and at the end of the step.
///
/// In the step of a landing both stay, the roller that carries the wheel and the one that comes
/// down. Otherwise one carries it: the ends of two neighbours can be equally low for degrees of a
/// turn, and two that stick obstruct each other. Of equal ones the one nearer to straight down
/// stays, as in the contact kinematics.
pub(super) fn leave_out_higher(
    found: &mut Vec<Candidate>,
    hub: &LinkPose,
    (rollers, scale): (&[RollerState], &Scale),
) {
    /// The robot's tilt and deflections must not decide: below this difference, in wheel radii, two
    /// rollers are equally low. 2 um for wheels of 50 mm. Chosen.
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
    /// Far above the rounding of a plane's points, and far below any step in a ground, in wheel
    /// radii. Chosen.
    const ONE_PLANE: f64 = 2e-4;
    one.normal.dot(hub_axis).abs() < UPRIGHT
        && one.normal.dot(&other.normal) > 1.0 - 1e-6
        && one.normal.dot(&(other.place_m - one.place_m)).abs() < ONE_PLANE * scale.length_m
}

/// Removes the places for which `outdone` finds a better one. The best one always stays, and a
/// removal does not improve another.
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use ilon_formats::LoadRobot;
    use ilon_robot::{Robot, Wheel};
    use nalgebra::Matrix3;

    use super::*;
    use crate::contact::reactions::reaction::{Member, Partner};
    use crate::robot::roller::FixedRoller;

    const SCALE: Scale = Scale {
        length_m: 0.05,
        load_kg: 3.0,
        gravity_m_s2: 9.81,
    };

    /// A place of a roller of the first wheel.
    fn place(roller: usize, place_m: Vector3<f64>, normal: Vector3<f64>, gap_m: f64) -> Candidate {
        let part = Part::Roller(0, roller);
        let between = (Member { body: 0, part }, Partner::Ground);
        Candidate {
            on_barrel: true,
            ..Candidate::new(between, (place_m, normal, gap_m))
        }
    }

    fn rollers_of(found: &[Candidate]) -> Vec<Part> {
        found.iter().map(|place| place.a.part).collect()
    }

    fn wheel() -> Wheel {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
        let robot = Robot::load(format!("{folder}/mecanum4.urdf")).expect("a shipped robot");
        robot.wheels[0].clone()
    }

    fn at_rest(wheel: &Wheel) -> Vec<RollerState> {
        let fixed = wheel.rollers.iter().map(|of| FixedRoller::new(wheel, of));
        fixed.map(|of| RollerState::at_rest(Arc::new(of))).collect()
    }

    /// A plane is one plane at any height: the lower of two rollers carries the wheel. At a step of
    /// a millimetre either roller may carry it, and both stay.
    #[test]
    fn rollers_hand_over_on_a_plane_at_any_height_and_not_over_a_step() {
        let axis = Vector3::y();
        for height_m in [-2.0, 0.0, 0.3] {
            let at = |x_m: f64, above_m: f64| Vector3::new(x_m, 0.0, height_m + above_m);
            let on = |step_m: f64| {
                let mut found = vec![
                    place(3, at(0.01, 0.0), Vector3::z(), 2e-6),
                    place(4, at(-0.01, step_m), Vector3::z(), 1e-6),
                ];
                leave_out_handed_over(&mut found, &axis, &SCALE);
                rollers_of(&found)
            };
            assert_eq!(on(0.0), [Part::Roller(0, 4)], "{height_m} m");
            assert_eq!(on(1e-3).len(), 2, "{height_m} m");
        }
    }

    /// A wheel on the floor and at a wall touches both, whichever of its rollers is nearer to its
    /// partner.
    #[test]
    fn rollers_on_the_floor_and_at_a_wall_both_stay() {
        let wheel = wheel();
        let rollers = at_rest(&wheel);
        let hub = LinkPose {
            center_m: Vector3::new(0.0, 0.0, 0.05),
            rotation: Matrix3::from_columns(&[-Vector3::z(), Vector3::x(), -Vector3::y()]),
        };
        for (on_floor_m, at_wall_m) in [(1e-6, 2e-6), (2e-6, 1e-6), (0.0, 0.0)] {
            let places = || {
                vec![
                    place(0, Vector3::zeros(), Vector3::z(), on_floor_m),
                    place(2, Vector3::new(0.05, 0.0, 0.05), -Vector3::x(), at_wall_m),
                ]
            };
            let mut found = places();
            leave_out_higher(&mut found, &hub, (&rollers, &SCALE));
            assert_eq!(found.len(), 2, "{on_floor_m} {at_wall_m}");
            let mut found = places();
            leave_out_handed_over(&mut found, &Vector3::y(), &SCALE);
            assert_eq!(found.len(), 2, "{on_floor_m} {at_wall_m}");
        }
    }

    /// Of two rollers equally near to the ground the one nearer to straight down stays, anywhere in
    /// the world: also on a ground that bends by half a milliradian, whose normals differ by half a
    /// metre a kilometre from the origin.
    #[test]
    fn which_of_two_equal_rollers_carries_does_not_depend_on_where_the_robot_is() {
        let wheel = wheel();
        let rollers = at_rest(&wheel);
        // The hub's axis lies along y; its own x points down.
        let rotation = Matrix3::from_columns(&[-Vector3::z(), Vector3::x(), -Vector3::y()]);
        let mut by_height: Vec<usize> = (0..rollers.len()).collect();
        let height_m = |at: usize| (rotation * wheel.rollers[at].center_in_hub_m).z;
        by_height.sort_by(|a, b| height_m(*a).total_cmp(&height_m(*b)));
        let (lowest, high) = (by_height[0], by_height[3]);
        assert!(height_m(high) > height_m(lowest) + 5e-3);
        let bend = 5e-4_f64;
        let leans = Vector3::new(bend.sin(), 0.0, bend.cos());
        for x_m in [0.0, 1e3, -1e3] {
            let hub = LinkPose {
                center_m: Vector3::new(x_m, 0.0, 0.05),
                rotation,
            };
            let at_m = Vector3::new(x_m, 0.0, 0.0);
            let mut found = vec![
                place(high, at_m, Vector3::z(), 1e-6),
                place(lowest, at_m, leans, 1e-6),
            ];
            leave_out_higher(&mut found, &hub, (&rollers, &SCALE));
            assert_eq!(rollers_of(&found), [Part::Roller(0, lowest)], "{x_m} m");
        }
    }
}
