//! Where the robot takes itself to be.

pub(crate) mod odometry;
pub(crate) mod odometry_covariance;
pub(crate) mod pose_filter;
pub(crate) mod tilt;
