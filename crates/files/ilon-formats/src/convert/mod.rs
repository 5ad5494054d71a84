//! Robots of other formats, written as the URDF that they come to: SDF and MJCF.
//!
//! Only the robot is read of them: links, joints, masses and shapes. What is written keeps the
//! place that it came from, so that errors are shown there, and goes the way of any URDF from there
//! on.

mod assembled;
mod choice;
mod ellipsoid;
mod malformed;
mod mjcf;
mod nested;
mod sdf;
mod writer;

use crate::error::RobotError;
use crate::options::LoadOptions;
use crate::urdf::UrdfText;

/// The URDF of a text whose root element is that of another format; `None` where it is not.
pub(crate) fn converted(
    root_tag: &str,
    file: &str,
    text: &str,
    options: &LoadOptions,
) -> Option<Result<UrdfText, RobotError>> {
    match root_tag {
        "sdf" => Some(sdf::converted(file, text, options)),
        "mujoco" | "mujocoinclude" => Some(mjcf::converted(file, text, options)),
        _ => None,
    }
}
