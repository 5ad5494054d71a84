//! What a step computes on its way.

use crate::dynamics::{ArrowSystem, Generalised, Prescribed};
use crate::tree::Tree;

/// What a step computes on its way, kept for its memory.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub system: ArrowSystem,
    pub forces: Generalised,
    pub prescribed: Prescribed,
    pub accelerations: Generalised,
    pub reactions: Generalised,
    pub predicted: Generalised,
    pub before: Generalised,
    pub drive_torques: Vec<f64>,
    pub wheel_bearing_torques: Vec<f64>,
    pub roller_bearing_torques: Vec<f64>,
}

impl Solution {
    pub fn new(tree: &Tree) -> Self {
        let zero = Generalised::zero(tree);
        let (wheels, rollers) = (tree.wheels.len(), tree.rollers.len());
        Self {
            system: ArrowSystem::new(tree),
            forces: zero.clone(),
            prescribed: Prescribed {
                wheels: vec![None; wheels],
                rollers: vec![None; rollers],
            },
            accelerations: zero.clone(),
            reactions: zero.clone(),
            predicted: zero.clone(),
            before: zero,
            drive_torques: vec![0.0; wheels],
            wheel_bearing_torques: vec![0.0; wheels],
            roller_bearing_torques: vec![0.0; rollers],
        }
    }
}
