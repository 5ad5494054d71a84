//! Estimators of the robot's pose and tilt.

pub(crate) mod odometry;
pub(crate) mod odometry_covariance;
pub(crate) mod pose_filter;
pub(crate) mod tilt;
