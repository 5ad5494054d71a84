//! Reduces the contacts of a chassis or a free body on ground with many small faces.
//!
//! Each face of uneven ground near a chassis is a contact: thousands if cells are small. All are
//! solved at once, and the work grows with the cube of their number. A rigid chassis is carried by
//! the highest points: in each region of it, as wide as a wheel, the nearest place is kept for each
//! side from which it may push. This changes the support of a chassis only within such a region.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3};

use crate::contact::reactions::reaction::Part;
use crate::contact::search::candidate::Candidate;

/// More places than this are thinned; boxes on kerbs have fewer. Chosen.
const MANY: usize = 64;
/// A place further out by a metre counts as nearer by this, so that of many equally near ones a
/// chassis stands on the outermost. Chosen.
const OUTWARD: f64 = 1e-5;

/// Thins the places from `first` on, of a chassis in its pose and of bodies on its joints, or of a
/// free body, by regions of the given size in metres.
pub(super) fn thin(
    (found, first): (&mut Vec<Candidate>, usize),
    floor_from_chassis: &Isometry3<f64>,
    region_m: f64,
) {
    if found.len() <= first + MANY {
        return;
    }
    let mut nearest = BTreeMap::new();
    for (index, place) in found.iter().enumerate().skip(first) {
        let local = floor_from_chassis.inverse_transform_point(&Point3::from(place.place_m));
        let region = local.coords.map(|x| (x / region_m).floor() as i64);
        let out_of_ground = floor_from_chassis.rotation.inverse() * place.normal;
        let axis = out_of_ground.iamax();
        let side = (axis, out_of_ground[axis] > 0.0);
        let gap_m = place.gap_m - OUTWARD * local.coords.norm();
        // Places of the chassis do not replace those of a body on a joint.
        let joint = match place.a.part {
            Part::Link(joint) => Some(joint),
            _ => None,
        };
        let key = (joint, [region.x, region.y, region.z], side);
        let held = nearest.entry(key).or_insert((gap_m, index));
        if gap_m < held.0 {
            *held = (gap_m, index);
        }
    }
    let mut stay: Vec<usize> = nearest.into_values().map(|(_, index)| index).collect();
    stay.sort_unstable();
    for (to, from) in stay.iter().enumerate() {
        found.swap(first + to, *from);
    }
    found.truncate(first + stay.len());
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::contact::reactions::reaction::{Member, Partner};

    fn place(part: Part, x_m: f64, gap_m: f64) -> Candidate {
        let between = (Member { body: 0, part }, Partner::Ground);
        let place_m = Vector3::new(x_m, 0.01, 0.01);
        Candidate::new(between, (place_m, Vector3::z(), gap_m))
    }

    /// A hundred places of the chassis in a region of 0.1 m: the nearest is kept. A place of an arm
    /// there is further away, and kept too, because the support of the chassis does not carry the
    /// arm.
    #[test]
    fn the_nearest_place_of_each_body_stays() {
        let chassis = |k: i32| place(Part::Chassis, 1e-4 * f64::from(k), 1e-6 * f64::from(k % 50));
        let mut found: Vec<Candidate> = (10..110).map(chassis).collect();
        found.push(place(Part::Link(2), 0.02, 1e-3));
        thin((&mut found, 0), &Isometry3::identity(), 0.1);
        let stay: Vec<(Part, f64)> = found.iter().map(|at| (at.a.part, at.gap_m)).collect();
        assert_eq!(stay, [(Part::Chassis, 0.0), (Part::Link(2), 1e-3)]);
        // Earlier results, of another body, are unchanged.
        let mut behind = vec![place(Part::Link(7), 0.3, 0.5)];
        behind.extend((10..110).map(chassis));
        thin((&mut behind, 1), &Isometry3::identity(), 0.1);
        let stay: Vec<(Part, f64)> = behind.iter().map(|at| (at.a.part, at.gap_m)).collect();
        assert_eq!(stay, [(Part::Link(7), 0.5), (Part::Chassis, 0.0)]);
        // As few as boxes on kerbs have are kept.
        let mut few: Vec<Candidate> = (10..74).map(chassis).collect();
        thin((&mut few, 0), &Isometry3::identity(), 0.1);
        assert_eq!(few.len(), 64);
    }
}
