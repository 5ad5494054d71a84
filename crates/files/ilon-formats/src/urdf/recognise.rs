//! Recognises wheels and rollers by structure and geometry, never by names: a wheel is a turning
//! joint with turning joints below it, on a ring about its axis.

use std::collections::{HashMap, HashSet};

use nalgebra::{Matrix3, SymmetricEigen, Unit, Vector3};

use super::tree::{Motion, Tree};

/// Smallest number of rollers of a wheel.
pub(super) const LEAST_ROLLERS: usize = 3;

/// Largest inclination of the axis of a ring of rollers: the sine of 30 degrees.
const MOST_RISE: f64 = 0.5;

/// A wheel joint and the roller joints below it.
pub(super) struct Candidate {
    pub(super) hub: usize,
    pub(super) rollers: Vec<usize>,
}

/// Finds the wheels, in the order of their joints in the file.
pub(super) fn find(tree: &Tree) -> Vec<Candidate> {
    let turning: Vec<usize> = tree.moving(Motion::Turning).collect();
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); tree.joints.len()];
    for &j in &turning {
        if let Some(above) = tree.turning_above(j) {
            below[above].push(j);
        }
    }
    let of_hubs = turning.iter().filter_map(|&hub| {
        let ends: Vec<usize> = below[hub]
            .iter()
            .copied()
            .filter(|&j| below[j].is_empty())
            .collect();
        let rollers = on_one_ring(tree, hub, &ends);
        (rollers.len() >= LEAST_ROLLERS).then_some(Candidate { hub, rollers })
    });
    let mut found: Vec<Candidate> = of_hubs.collect();
    // One upright joint (within 8 degrees) above only level ones turns the robot on its wheels,
    // like the last joint of a planar base.
    if let [only] = &found[..]
        && tree.joints[only.hub].axis.z.abs() > 0.99
        && only.rollers.iter().all(|&roller| tree.is_level(roller))
    {
        found.clear();
    }
    found
}

/// Returns the joints whose axes pass the hub's axis at the common distance, within a twentieth.
fn on_one_ring(tree: &Tree, hub: usize, joints: &[usize]) -> Vec<usize> {
    let distance_m = |j: usize| {
        let (hub, joint) = (&tree.joints[hub], &tree.joints[j]);
        let from_hub = joint.origin - hub.origin;
        match Unit::try_new(hub.axis.cross(&joint.axis), 1e-6) {
            Some(normal) => from_hub.dot(&normal).abs(),
            None => from_hub.cross(&hub.axis).norm(),
        }
    };
    let mut distances: Vec<f64> = joints.iter().map(|&j| distance_m(j)).collect();
    distances.sort_by(f64::total_cmp);
    let Some(&common_m) = distances.get(distances.len() / 2) else {
        return Vec::new();
    };
    if common_m < 1e-6 {
        return Vec::new();
    }
    joints
        .iter()
        .copied()
        .filter(|&j| (distance_m(j) - common_m).abs() <= 0.05 * common_m)
        .collect()
}

/// Returns joints that do not turn but carry rollers: three or more turning joints with nothing
/// else, some of them on inclined axes, as on a ring around a level axis; each with the number of
/// rollers.
pub(super) fn fixed_hubs(tree: &Tree) -> Vec<(usize, usize)> {
    let above: HashSet<usize> = tree
        .moving(Motion::Turning)
        .filter_map(|j| tree.turning_above(j))
        .collect();
    let mut on_link: HashMap<usize, (usize, bool)> = HashMap::new();
    for j in tree.moving(Motion::Turning).filter(|j| !above.contains(j)) {
        if tree.turning_above(j).is_none() {
            let (count, leaning) = on_link.entry(tree.joints[j].parent).or_default();
            *count += 1;
            *leaning |= !tree.is_level(j);
        }
    }
    (0..tree.joints.len())
        .filter_map(|hub| {
            let joint = &tree.joints[hub];
            let &(count, leaning) = on_link.get(&joint.child)?;
            // Wheels at the corners of a chassis are on a ring too, but on a horizontal one.
            let is_level = |axis: Vector3<f64>| axis.z.abs() < MOST_RISE;
            let carries =
                leaning && count >= LEAST_ROLLERS && ring_axis(tree, hub).is_some_and(is_level);
            (joint.motion != Motion::Turning && carries).then_some((hub, count))
        })
        .collect()
}

/// Returns level turning joints that carry a ring of fixed joints with axes and shapes: rollers
/// that were left fixed.
pub(super) fn fixed_rollers(tree: &Tree) -> Vec<Candidate> {
    /// The cosine of the least angle between a roller's axis and its hub's, of 10 degrees.
    const APART: f64 = 0.985;
    let of_hub = |hub: usize| {
        let axis = &tree.joints[hub].axis;
        let is_roller = |&j: &usize| {
            let joint = &tree.joints[j];
            let has_shape = !tree.links[joint.child].shapes.is_empty();
            joint.motion == Motion::Fixed
                && joint.states_axis
                && has_shape
                && joint.axis.dot(axis).abs() < APART
        };
        let on_link = &tree.links[tree.joints[hub].child].joints_below;
        let rollers: Vec<usize> = on_link.iter().copied().filter(is_roller).collect();
        let rollers = on_one_ring(tree, hub, &rollers);
        (rollers.len() >= LEAST_ROLLERS).then_some(Candidate { hub, rollers })
    };
    let hubs = tree
        .moving(Motion::Turning)
        .filter(|&hub| tree.is_level(hub));
    hubs.filter_map(of_hub).collect()
}

/// Returns the axis of the ring of rollers on a joint's link, in the body frame: the direction in
/// which their positions spread least.
pub(super) fn ring_axis(tree: &Tree, hub: usize) -> Option<Vector3<f64>> {
    let link = tree.joints[hub].child;
    let on_link: Vec<Vector3<f64>> = tree
        .moving(Motion::Turning)
        .filter(|&j| tree.joints[j].parent == link)
        .map(|j| tree.joints[j].origin.coords)
        .collect();
    if on_link.len() < LEAST_ROLLERS {
        return None;
    }
    let middle = on_link.iter().sum::<Vector3<f64>>() / on_link.len() as f64;
    let spread: Matrix3<f64> = on_link
        .iter()
        .map(|p| (p - middle) * (p - middle).transpose())
        .sum();
    let eigen = SymmetricEigen::new(spread);
    let (least, _) = eigen.eigenvalues.argmin();
    let axis = eigen.eigenvectors.column(least).into_owned();
    // To the left, in which wheels drive forward.
    let leading = if axis.y.abs() > 1e-6 { axis.y } else { axis.x };
    Some(if leading < 0.0 { -axis } else { axis })
}
