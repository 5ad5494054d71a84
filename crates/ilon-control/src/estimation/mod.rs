//! Where the robot takes itself to be.

pub(crate) mod odometry;
pub(crate) mod pose_filter;
