//! Parameters for the controllers of ros2_controllers, with the radii that the rollers really roll on.
//!
//! `mecanum_drive_controller` and `omni_wheel_drive_controller` know one wheel radius and one lever of yaw. A wheel of rollers has no
//! single radius: straight ahead it rolls on its radius, and sideways a wheel of n tilted rollers buys sin(pi/n)/(pi/n) of what the
//! ideal kinematics says (`ilon_control::ContactKinematics`). The parameters given here are right for driving ahead and for turning;
//! what they are off by sideways, for which the controllers have no parameter, is said beside them.

mod drive_parameters;
mod text;

pub use drive_parameters::{Controller, DriveParameters, Unsuitable};
pub use text::yaml;
