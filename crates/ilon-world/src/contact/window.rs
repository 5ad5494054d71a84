//! The contact window: which rollers of a wheel need their shapes in the world now.
//!
//! On a plane the lowest roller of a wheel is the only one that touches, and the next one takes over where the two
//! barrels meet. Near anything else (a kerb, a rough surface) every roller that the ground could reach within the next
//! steps needs its shape too.

use nalgebra::{Isometry3, Vector3};
use parry3d::bounding_volume::BoundingVolume;
use parry3d::shape::Shape;
use rapier3d::math::Real;

use crate::RollerShape;
use crate::engine::convert;
use crate::ground::Ground;
use crate::robot::wheel::WheelBody;

/// How far around a roller the ground counts as being in reach, in metres: wheels turn by less between two looks.
const MARGIN_M: Real = 2e-3;

/// The roller whose place on the rim is nearest to straight down on the plane.
pub(crate) fn lowest(wheel: &WheelBody, floor_from_hub: &Isometry3<f64>) -> usize {
    let down_in_hub = floor_from_hub.rotation.inverse() * -Vector3::z();
    let down_rad = libm::atan2(down_in_hub.y, down_in_hub.x);
    let off_rad = |i: usize| ilon_robot::wrap_angle(wheel.rollers[i].place_rad - down_rad).abs();
    (0..wheel.rollers.len())
        .min_by(|&a, &b| off_rad(a).total_cmp(&off_rad(b)))
        .unwrap_or(0)
}

/// Fills `needed` with the rollers of a wheel that could touch something soon, in their order.
pub(crate) fn in_reach(
    wheel: &WheelBody,
    shapes: &[RollerShape],
    floor_from_hub: &Isometry3<f64>,
    ground: &Ground,
    needed: &mut Vec<usize>,
) {
    needed.clear();
    let lowest = lowest(wheel, floor_from_hub);
    if ground.is_plain() {
        needed.push(lowest);
        return;
    }
    for (i, shape) in shapes.iter().enumerate() {
        let pose = convert::pose(&(floor_from_hub * wheel.rollers[i].hub_from_roller));
        let reach = shape.compute_aabb(&pose).loosened(MARGIN_M);
        if i == lowest || ground.reaches(&reach) {
            needed.push(i);
        }
    }
}

/// Which roller every slot stands for, so that all `needed` ones have a slot and none moves without need.
///
/// `slots` holds the rollers of a wheel's slots and is changed in place. Says whether there were slots enough.
pub(crate) fn assign(slots: &mut [usize], needed: &[usize]) -> bool {
    if slots.len() < needed.len() {
        return false;
    }
    for &roller in needed {
        if slots.contains(&roller) {
            continue;
        }
        let free = slots.iter().position(|held| !needed.contains(held));
        match free {
            Some(slot) => slots[slot] = roller,
            None => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slot_moves_only_when_its_roller_is_no_longer_needed() {
        let mut slots = [4, 5, 6];
        assert!(assign(&mut slots, &[5, 6, 7]));
        assert_eq!(slots, [7, 5, 6]);
        assert!(assign(&mut slots, &[6]));
        assert_eq!(slots, [7, 5, 6]);
    }

    #[test]
    fn too_few_slots_are_said_so() {
        let mut slots = [0];
        assert!(!assign(&mut slots, &[0, 1]));
    }
}
