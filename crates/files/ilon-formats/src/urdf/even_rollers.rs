//! Equalises wheels that only differ by the facets of their meshes.
//!
//! A left-handed wheel and its mirror image have different facets, so a file of equal wheels shows
//! radii some tenths of a millimetre apart: the robot would stand on three of its wheels.

use urdf_rs::Geometry;

use super::recognise::Candidate;
use super::tree::{PlacedShape, Tree};
use crate::model::{Remark, Wheel};

/// Relative difference of radii that facets can cause.
const FACETS: f64 = 0.01;
/// Largest relative difference of the rings of equal wheels: joints are given by numbers, not by
/// facets.
const SAME_RING: f64 = 2e-3;
/// Equal wheels have the same roller angle, except for its sign, within this.
const SAME_GAMMA_RAD: f64 = 0.01;

/// Gives wheels from meshes that are equal up to facets one radius, the largest: corners of facets
/// lie on the true surface, their middles below it.
pub(super) fn even_out(
    tree: &Tree,
    candidates: &[Candidate],
    wheels: &mut [(usize, Wheel)],
    remarks: &mut Vec<Remark>,
) {
    let is_mesh = |shape: &PlacedShape| matches!(shape.geometry, Geometry::Mesh { .. });
    let is_of_meshes = |joint: usize| {
        let Some(candidate) = candidates.iter().find(|candidate| candidate.hub == joint) else {
            // A wheel without rollers is measured by its collision shapes, or else by its visual
            // shapes.
            let body = tree.lone_body(tree.joints[joint].child);
            let measured = [&body.shapes, &body.visuals]
                .into_iter()
                .find(|of| !of.is_empty());
            return measured.is_some_and(|shapes| shapes.iter().any(is_mesh));
        };
        let links = candidate.rollers.iter();
        let links = links.map(|&j| &tree.links[tree.joints[j].child]);
        let mut shapes = links.flat_map(|link| link.shapes.iter().chain(&link.visuals));
        shapes.any(is_mesh)
    };
    let all: Vec<usize> = (0..wheels.len())
        .filter(|&i| is_of_meshes(wheels[i].0))
        .collect();
    let radii_m: Vec<f64> = wheels.iter().map(|(_, wheel)| wheel.radius_m).collect();
    let largest_m: Vec<(usize, f64)> = all
        .iter()
        .map(|&i| {
            let equal = all
                .iter()
                .filter(|&&j| are_equal(&wheels[i].1, &wheels[j].1));
            (i, equal.map(|&j| radii_m[j]).fold(radii_m[i], f64::max))
        })
        .collect();
    for (i, radius_m) in largest_m {
        let wheel = &mut wheels[i].1;
        let grown_m = radius_m - wheel.radius_m;
        if grown_m <= 0.0 {
            continue;
        }
        let [own_mm, equal_mm] = [wheel.radius_m, radius_m].map(|m| format!("{:.3}", 1e3 * m));
        // A difference below the displayed digits is rounding.
        if own_mm != equal_mm {
            let words = format!(
                "its meshes make a radius of {own_mm} mm, those of an equal wheel {equal_mm} mm: the facets explain it, and both are \
                 taken to have the larger"
            );
            remarks.push(Remark::new(format!("wheel `{}`", wheel.name), words));
        }
        wheel.radius_m = radius_m;
        for roller in &mut wheel.rollers {
            roller.radius_m += grown_m;
        }
    }
}

/// Whether two wheels differ only by their facets.
fn are_equal(p: &Wheel, q: &Wheel) -> bool {
    let ring_m = |wheel: &Wheel| {
        let rings_m = wheel.rollers.iter().map(|roller| roller.ring_radius_m());
        rings_m.sum::<f64>() / wheel.rollers.len() as f64
    };
    let within = |p: f64, q: f64, share: f64| (p - q).abs() <= share * p.max(q);
    p.rollers.len() == q.rollers.len()
        && within(ring_m(p), ring_m(q), SAME_RING)
        && within(p.radius_m, q.radius_m, FACETS)
        && (p.gamma_rad.abs() - q.gamma_rad.abs()).abs() < SAME_GAMMA_RAD
}
