//! Converts commands to torques: the wheel loops of a scenario, and the motors of its robot.

pub(crate) mod drive;
pub mod motors;
