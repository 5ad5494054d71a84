//! What the robot's sensors measure, with their errors, and what dead reckoning makes of the wheels' angles.

pub(crate) mod fusion;
pub(crate) mod hubs;
pub(crate) mod imu;
pub(crate) mod posed_odometry;
pub(crate) mod reckoning;
pub mod sensors;
