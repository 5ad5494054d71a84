//! The robot's sensors with their errors, and dead reckoning from the wheels' angles.

pub(crate) mod fusion;
pub(crate) mod hubs;
pub(crate) mod imu;
pub(crate) mod posed_odometry;
pub(crate) mod reckoning;
pub mod sensors;
