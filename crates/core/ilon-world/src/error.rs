//! Errors of building a world.

/// Why a world could not be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A setting is out of range.
    #[error("{name} is {value}, but must be {range}")]
    Setting {
        /// The setting's name.
        name: &'static str,
        /// The given value.
        value: f64,
        /// The valid range.
        range: &'static str,
    },
    /// The robot cannot start at its place: boxes or bumps of the ground are in its way.
    #[error(
        "the robot cannot stand where it starts: put down there, {reason}; start it elsewhere, or move what is in its way"
    )]
    NoPlaceToStand {
        /// The obstacle or fault.
        reason: String,
    },
    /// A feature that rapier's own contact solver does not have.
    #[error("contacts that rapier solves cannot have {what}; let ilon solve them, or {remedy}")]
    NotInRapier {
        /// The feature.
        what: String,
        /// An alternative.
        remedy: &'static str,
    },
    /// A joint between bodies that cannot be simulated.
    #[error("joint `{joint}`: {reason}")]
    Joint {
        /// The joint's name.
        joint: String,
        /// The fault, and how to repair it.
        reason: String,
    },
    /// A free body that is invalid, or cannot start at its place.
    #[error("body `{name}`: {reason}")]
    FreeBody {
        /// The body's name.
        name: String,
        /// The fault, and how to repair it.
        reason: String,
    },
    /// A world without a robot was requested.
    #[error("a world of no robots; give it one or more")]
    NoBodies,
    /// A robot without wheels has nothing to stand on.
    #[error("the robot has no wheels")]
    NoWheels,
    /// A wheel that cannot be simulated.
    #[error("wheel `{wheel}`: {reason}")]
    Wheel {
        /// The wheel's name.
        wheel: String,
        /// The fault, and how to repair it.
        reason: String,
    },
}

/// Ranges of numbers.
pub(crate) const FINITE: &str = "finite";
pub(crate) const POSITIVE: &str = "finite and above 0";
pub(crate) const NOT_NEGATIVE: &str = "finite and not below 0";

/// Refuses the first of these numbers, each with its name, that is not in its range.
pub(crate) fn check_numbers(
    numbers: impl IntoIterator<Item = (&'static str, f64, &'static str)>,
) -> Result<(), WorldError> {
    let is_within = |value: f64, range: &str| match range {
        POSITIVE => value > 0.0,
        NOT_NEGATIVE => value >= 0.0,
        _ => true,
    };
    for (name, value, range) in numbers {
        if !(value.is_finite() && is_within(value, range)) {
            return Err(WorldError::Setting { name, value, range });
        }
    }
    Ok(())
}
