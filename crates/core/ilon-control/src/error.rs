//! The crate's error type.

use crate::kinematics::singularity::{Singularity, quoted};

/// Reasons why a controller, a reference or a motor cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ControlError {
    /// Fewer than three wheels with rollers, or two on tyres, cannot span the three freedoms of
    /// motion in the plane.
    #[error(
        "the robot has {count} driven wheel(s); omnidirectional motion needs at least 3 with rollers, driving and turning 2 on tyres"
    )]
    TooFewWheels {
        /// The number of wheels.
        count: usize,
    },
    /// Condition c.1 of Lemma 1 fails: the rollers of these wheels roll in the wheel's own
    /// direction (gamma = 90 deg), so that turning the wheel moves nothing.
    #[error(
        "loss of control authority: the rollers of {} roll the way the wheel drives (|gamma| = 90 deg), so the motor \
         cannot push; turn the roller axes away from the hub axis (Lemma 1, condition c.1)",
        quoted(.wheels)
    )]
    NoControlAuthority {
        /// Names of these wheels.
        wheels: Vec<String>,
    },
    /// A wheel carries no rollers.
    #[error("wheel `{wheel}` carries no rollers, so its contact with the ground is unknown")]
    NoRollers {
        /// Name of the wheel.
        wheel: String,
    },
    /// Condition c.2 of Lemma 1 fails: M of eq. (8) has rank below 3.
    #[error("loss of controllability: {singularity} (Lemma 1, condition c.2: rank M < 3)")]
    Uncontrollable {
        /// The free motion, its geometric cause, and possible repairs.
        singularity: Singularity,
    },
    /// A number that must be finite and positive is not.
    #[error("{what} is {value}; it must be finite and above zero")]
    NotPositive {
        /// Name of the number.
        what: String,
        /// The rejected value.
        value: f64,
    },
    /// A number that must be finite and zero or more is not.
    #[error("{what} is {value}; it must be finite and not below zero")]
    Negative {
        /// Name of the number.
        what: String,
        /// The rejected value.
        value: f64,
    },
    /// A number is NaN or infinite.
    #[error("{what} is {value}; it must be a finite number")]
    NotFinite {
        /// Name of the number.
        what: String,
        /// The rejected value.
        value: f64,
    },
    /// A number exceeds its upper limit.
    #[error("{what} is {value}; it must be {most} at most")]
    TooLarge {
        /// Name of the number.
        what: String,
        /// The rejected value.
        value: f64,
        /// The largest allowed value.
        most: f64,
    },
    /// A guidance without tasks, which would never move.
    #[error("the guidance has no tasks: name one, such as the position's feedback")]
    NoTasks,
    /// A task is listed twice.
    #[error("the guidance has the task `{task}` twice: name it once")]
    TwiceATask {
        /// Name of the task.
        task: &'static str,
    },
    /// A gain is unstable with the periods and delays of its loop.
    #[error("{what} is {value:.4}, which is unstable {because}; below {most:.4} it is stable")]
    Unstable {
        /// Name of the gain.
        what: String,
        /// The rejected value.
        value: f64,
        /// The largest stable value.
        most: f64,
        /// The period, delay and damping behind the limit.
        because: String,
    },
    /// The position gain K_r is not symmetric positive definite, which eq. (21) needs.
    #[error(
        "the position gain [[{xx}, {xy}], [{yx}, {yy}]] must be symmetric and positive definite"
    )]
    PositionGain {
        /// Row x, column x, in 1/s.
        xx: f64,
        /// Row x, column y, in 1/s.
        xy: f64,
        /// Row y, column x, in 1/s.
        yx: f64,
        /// Row y, column y, in 1/s.
        yy: f64,
    },
    /// A path by waypoints needs at least two of them.
    #[error("a path by waypoints needs at least 2 points, got {count}")]
    TooFewWaypoints {
        /// The number of points given.
        count: usize,
    },
    /// Two lists that belong together differ in length.
    #[error("{left} ({left_count}) and {right} ({right_count}) must be equally many")]
    LengthMismatch {
        /// What the first list holds.
        left: &'static str,
        /// How many it holds.
        left_count: usize,
        /// What the second list holds.
        right: &'static str,
        /// How many it holds.
        right_count: usize,
    },
    /// Waypoint times must start at zero or later and grow.
    #[error(
        "waypoint {index} is at {time_s} s, not later than the one before; times must increase"
    )]
    TimesNotGrowing {
        /// Index of the offending waypoint, from 0.
        index: usize,
        /// Its time in seconds.
        time_s: f64,
    },
    /// A heading along the path's tangent needs a path that moves.
    #[error(
        "heading along the tangent needs a path that moves: {reason}; give a constant heading or a rate instead"
    )]
    NoTangent {
        /// Description of where the path has no tangent.
        reason: String,
    },
    /// Grip and motors do not suffice to continue along a path, however slowly.
    #[error(
        "the path cannot be driven from {own_time_s:.3} s of its own time on, however slowly: grip or motors do not suffice to stand there, or to \
         start"
    )]
    CannotBeDriven {
        /// The place on the path, in the path's own time in seconds.
        own_time_s: f64,
    },
    /// Headings at waypoints need a path by waypoints.
    #[error(
        "headings at waypoints need a path by waypoints; give a constant heading, a rate or the tangent instead"
    )]
    HeadingsWithoutWaypoints,
}

/// Returns `value` if it is finite and above zero.
pub(crate) fn positive(what: &str, value: f64) -> Result<f64, ControlError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(ControlError::NotPositive {
            what: what.to_owned(),
            value,
        })
    }
}

/// Returns `value` if it is finite and not below zero.
pub(crate) fn not_negative(what: &str, value: f64) -> Result<f64, ControlError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(ControlError::Negative {
            what: what.to_owned(),
            value,
        })
    }
}

/// Returns `value` if it is finite.
pub(crate) fn finite(what: &str, value: f64) -> Result<f64, ControlError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(ControlError::NotFinite {
            what: what.to_owned(),
            value,
        })
    }
}
