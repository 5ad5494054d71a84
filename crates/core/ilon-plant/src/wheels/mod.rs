//! What turns commands into torques: the wheel loops as a scenario sets them, and the motors of its robot.

pub(crate) mod drive;
pub mod motors;
