//! What a scenario asks of wheels, joints and body at each time of the run: paths and waypoints, logs that are played back, targets of joints.

pub mod command;
pub mod joint_targets;
pub mod playback;
pub mod reference;
mod waypoints;
