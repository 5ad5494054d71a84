//! The demand on wheels, joints and body at each time of the run: paths and waypoints, logs, joint
//! targets.

pub mod command;
pub mod joint_targets;
pub mod playback;
pub mod reference;
mod waypoints;
