//! Parameters for the controllers of ros2_controllers, with the radii that the rollers really roll
//! on.
//!
//! `mecanum_drive_controller` and `omni_wheel_drive_controller` have one wheel radius and one lever
//! of yaw. A wheel with rollers has no single radius. Straight ahead it rolls on its radius;
//! sideways, a wheel of n tilted rollers gives sin(pi/n)/(pi/n) of the ideal kinematics
//! (`ilon_control::ContactKinematics`). The parameters here are right for driving ahead and for
//! turning. Their error sideways, for which the controllers have no parameter, is written beside
//! them.

mod drive_parameters;
mod on_tyres;
mod text;
mod text_on_tyres;

pub use drive_parameters::{Controller, DriveParameters, Unsuitable};
pub use on_tyres::{TyreController, TyreDrive};
pub use text::yaml;
pub use text_on_tyres::yaml_on_tyres;
