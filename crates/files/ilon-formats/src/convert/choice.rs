//! Which of the robots in a file is meant.

use crate::error::{Fault, RobotError};
use crate::urdf::{UrdfText, wheels_seen};

/// Longest URDF that is read, in bytes: twice that of any robot known, and more than that of a
/// thousand bodies. A question to the user tries its answers first: five reads of 0.3 s each.
const MOST_BYTES: usize = 1_000_000;

/// Of robots that a file may hold, the one in which the most wheels are seen; of as many, the
/// first. An arm has more joints than the base that it stands on.
pub(super) fn with_most_wheels(
    written: impl IntoIterator<Item = Result<UrdfText, RobotError>>,
) -> Option<Result<UrdfText, RobotError>> {
    let written = written.into_iter().map(|robot| robot.and_then(readable));
    let mut written = written.peekable();
    let first = written.next();
    // Nothing is to be counted in the only one.
    if written.peek().is_none() {
        return first;
    }
    let mut best: Option<((usize, usize), Result<UrdfText, RobotError>)> = None;
    for robot in first.into_iter().chain(written) {
        let wheels = robot.as_ref().map_or((0, 0), wheels_seen);
        if best.as_ref().is_none_or(|(most, _)| wheels > *most) {
            best = Some((wheels, robot));
        }
    }
    best.map(|(_, robot)| robot)
}

/// Refuses a robot of more parts than can be read in good time: a megabyte may hold 18,000 bodies.
fn readable(robot: UrdfText) -> Result<UrdfText, RobotError> {
    if robot.text.len() <= MOST_BYTES {
        return Ok(robot);
    }
    let megabytes = |bytes: usize| format!("{:.1} MB", 1e-6 * bytes as f64);
    let [length, most] = [robot.text.len(), MOST_BYTES].map(megabytes);
    let what = format!("links, joints and shapes of {length} as URDF");
    Err(RobotError::new(&robot.file, Fault::TooLarge { what, most }))
}
