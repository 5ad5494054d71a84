//! Which of the robots in a file is meant.

use crate::error::RobotError;
use crate::urdf::{UrdfText, wheels_seen};

/// Of robots that a file may hold, the one in which the most wheels are seen; of as many, the first. An arm has more joints than the
/// base that it stands on.
pub(super) fn with_most_wheels(
    written: impl IntoIterator<Item = Result<UrdfText, RobotError>>,
) -> Option<Result<UrdfText, RobotError>> {
    let mut written = written.into_iter().peekable();
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
