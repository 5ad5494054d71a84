//! Errors of the engine.

use thiserror::Error;

/// Why a robot or a setting cannot be simulated.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum OracleError {
    /// A roller has the collision shapes of its file.
    #[error(
        "roller `{roller}` has the shapes of its file: the oracle knows exact barrels only; load the robot with exact rollers"
    )]
    NoBarrel {
        /// The roller's joint.
        roller: String,
    },
    /// A part has no inertia about an axis that it can turn about.
    #[error("`{part}` has no inertia about its own axis: give it one")]
    NoInertia {
        /// The part's joint.
        part: String,
    },
    /// A wheel or a joint is on a joint that does not precede it.
    #[error(
        "`{part}` hangs on a joint that the robot does not have before it: joints stand parents first"
    )]
    NoCarrier {
        /// The wheel's or the joint's name.
        part: String,
    },
    /// A joint has an element that the oracle does not support.
    #[error(
        "joint `{joint}` is neither free nor sprung: the oracle knows no other; free it, or hold it"
    )]
    Role {
        /// The joint's name.
        joint: String,
    },
    /// A setting is not a number in its range.
    #[error("{setting} = {value} is out of range: it must be finite and {range}")]
    Setting {
        /// The setting's name.
        setting: &'static str,
        /// Its value.
        value: f64,
        /// The allowed range.
        range: &'static str,
    },
    /// The step is too long for a contact spring or a bearing.
    #[error(
        "a step of {step_s:e} s is too long for the {of}: take at most {longest_s:e} s, or soften it"
    )]
    StepTooLong {
        /// The step, in seconds.
        step_s: f64,
        /// What is too fast for the step.
        of: &'static str,
        /// The longest step, in seconds.
        longest_s: f64,
    },
    /// The motion is no longer finite.
    #[error("the motion diverged at {time_s} s")]
    Diverged {
        /// Simulated time in seconds.
        time_s: f64,
    },
}
