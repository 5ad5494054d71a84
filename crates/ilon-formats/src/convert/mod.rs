//! Robots of other formats, written as the URDF that they come to: SDF and MJCF.
//!
//! Only the robot is read of them: links, joints, masses and shapes. What is written keeps the place that it came from, so that
//! errors are shown there, and goes the way of any URDF from there on.

mod mjcf;
mod sdf;
mod writer;

use crate::error::RobotError;
use crate::options::LoadOptions;
use crate::urdf::{Prepared, wheels_seen};

/// Of robots that a file may hold, the one in which the most wheels are seen; of as many, the first. An arm has more joints than the
/// base that it stands on.
fn with_most_wheels(
    written: impl IntoIterator<Item = Result<Prepared, RobotError>>,
) -> Option<Result<Prepared, RobotError>> {
    let mut best: Option<((usize, usize), Result<Prepared, RobotError>)> = None;
    for robot in written {
        let wheels = robot.as_ref().map_or((0, 0), wheels_seen);
        if best.as_ref().is_none_or(|(most, _)| wheels > *most) {
            best = Some((wheels, robot));
        }
    }
    best.map(|(_, robot)| robot)
}

/// The URDF of a text whose root element is that of another format; `None` where it is not.
pub(crate) fn converted(
    root_tag: &str,
    file: &str,
    text: &str,
    options: &LoadOptions,
) -> Option<Result<Prepared, RobotError>> {
    match root_tag {
        "sdf" => Some(sdf::converted(file, text)),
        "mujoco" | "mujocoinclude" => Some(mjcf::converted(file, text, options)),
        _ => None,
    }
}
