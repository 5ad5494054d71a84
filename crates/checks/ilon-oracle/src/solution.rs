//! Intermediate results of a step.

use crate::dynamics::ArrowSystem;
use crate::forces::{Forces, Prescribed};
use crate::generalised::Generalised;
use crate::posture::Carried;
use crate::tree::Tree;

/// Intermediate results of a step, kept to reuse their memory.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub system: ArrowSystem,
    pub forces: Forces,
    pub prescribed: Prescribed,
    pub accelerations: Generalised,
    pub reactions: Forces,
    pub predicted: Generalised,
    pub before: Generalised,
    /// The motion of the carriers at the start of the step.
    pub carried: Vec<Carried>,
    /// Dissipative forces in joints, in N m or N.
    pub joint_losses: Vec<f64>,
    /// The load of each roller on its axle in the last step, in N.
    pub roller_loads_n: Vec<f64>,
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
            forces: Forces::zero(tree),
            prescribed: Prescribed {
                wheels: vec![None; wheels],
                rollers: vec![None; rollers],
            },
            accelerations: zero.clone(),
            reactions: Forces::zero(tree),
            predicted: zero.clone(),
            before: zero,
            carried: vec![Carried::REST; tree.carriers()],
            joint_losses: vec![0.0; tree.joints.len()],
            roller_loads_n: vec![0.0; rollers],
            drive_torques: vec![0.0; wheels],
            wheel_bearing_torques: vec![0.0; wheels],
            roller_bearing_torques: vec![0.0; rollers],
        }
    }
}
