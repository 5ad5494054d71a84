//! Fewer places where a chassis lies on ground of many small faces.
//!
//! Each face of a relief that is near a chassis is a place of contact: thousands where cells are small. All of them are solved at once, and the work
//! grows with the cube of their number. A rigid chassis is carried by what reaches highest: in each region of it, as wide as a wheel, the place that
//! is nearest stays, for each side that it may push from. How a chassis is carried changes by that over less than such a region.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3};

use crate::contact::candidate::Candidate;

/// What more places than this are thinned: more than boxes on kerbs make.
const MANY: usize = 64;
/// A place that is further out by a metre counts as nearer by so much, so that of many as near a chassis stands on the outermost.
const OUTWARD: f64 = 1e-5;

/// Thins the places of a chassis in its pose, by regions of so many metres.
pub(super) fn thin(found: &mut Vec<Candidate>, floor_from_chassis: &Isometry3<f64>, region_m: f64) {
    if found.len() <= MANY {
        return;
    }
    let mut nearest = BTreeMap::new();
    for (index, place) in found.iter().enumerate() {
        let local = floor_from_chassis.inverse_transform_point(&Point3::from(place.place_m));
        let region = local.coords.map(|x| (x / region_m).floor() as i64);
        let out_of_ground = floor_from_chassis.rotation.inverse() * place.normal;
        let axis = out_of_ground.iamax();
        let side = (axis, out_of_ground[axis] > 0.0);
        let gap_m = place.gap_m - OUTWARD * local.coords.norm();
        let key = ([region.x, region.y, region.z], side);
        let held = nearest.entry(key).or_insert((gap_m, index));
        if gap_m < held.0 {
            *held = (gap_m, index);
        }
    }
    let mut stay: Vec<usize> = nearest.into_values().map(|(_, index)| index).collect();
    stay.sort_unstable();
    for (to, from) in stay.iter().enumerate() {
        found.swap(to, *from);
    }
    found.truncate(stay.len());
}
