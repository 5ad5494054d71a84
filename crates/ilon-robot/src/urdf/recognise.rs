//! Which joints are wheels and which are rollers. Structure and geometry decide, never names: a wheel is a turning joint with
//! turning joints of its own below it, on a ring about its axis.

use nalgebra::Unit;

use super::tree::{Motion, Tree};

/// Fewest rollers that make a wheel.
const LEAST_ROLLERS: usize = 3;

/// A wheel joint and the roller joints below it.
pub(super) struct Candidate {
    pub(super) hub: usize,
    pub(super) rollers: Vec<usize>,
}

/// Finds the wheels, in the order of their joints in the file.
pub(super) fn find(tree: &Tree) -> Vec<Candidate> {
    let turning: Vec<usize> = (0..tree.joints.len())
        .filter(|&j| tree.joints[j].motion == Motion::Turning)
        .collect();
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); tree.joints.len()];
    for &j in &turning {
        if let Some(above) = tree.turning_above(j) {
            below[above].push(j);
        }
    }
    turning
        .iter()
        .filter_map(|&hub| {
            let ends: Vec<usize> = below[hub]
                .iter()
                .copied()
                .filter(|&j| below[j].is_empty())
                .collect();
            let rollers = on_one_ring(tree, hub, &ends);
            (rollers.len() >= LEAST_ROLLERS).then_some(Candidate { hub, rollers })
        })
        .collect()
}

/// Those of the joints whose axes pass the hub's axis at the common distance, within a twentieth.
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
