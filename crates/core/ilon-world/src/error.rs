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
    /// A wheel without rollers touches nothing.
    #[error("wheel `{wheel}` has no rollers: it would touch nothing")]
    NoRollers {
        /// The wheel.
        wheel: String,
    },
    /// A roller's barrel has no end: its profile reaches the axis before its end.
    #[error(
        "wheel `{wheel}`: its rollers are so long for their radius that their profile vanishes {missing_mm:.2} mm \
         before the end; use more or thicker rollers"
    )]
    RollerEndsVanish {
        /// The wheel's name.
        wheel: String,
        /// By how much the end sphere's radius is negative, in millimetres.
        missing_mm: f64,
    },
    /// A roller should use the shapes of its file, but one of them is a mesh without volume.
    #[error(
        "wheel `{wheel}`: roller `{roller}` has a collision mesh without volume; take barrels, or mend the mesh"
    )]
    FlatRoller {
        /// The wheel's name.
        wheel: String,
        /// The roller's name.
        roller: String,
    },
    /// Rollers should have a tread and the shapes of their file: treads exist only for barrels.
    #[error(
        "wheel `{wheel}`: its rollers have the shapes of their file and a tread, which only barrels can have; take barrels, or \
         leave the tread out"
    )]
    TreadOnModelled {
        /// The wheel's name.
        wheel: String,
    },
    /// Rollers should have the shapes of their file with rolling resistance or creep, which need
    /// the motion of the contact point: it is known only for shapes by numbers.
    #[error(
        "wheel `{wheel}`: its rollers have the shapes of their file, of which rolling resistance and creep are not known; take barrels, or \
         leave the floor's and the rollers' rolling resistance and the creep out"
    )]
    DragOnModelled {
        /// The wheel's name.
        wheel: String,
    },
    /// Rollers should have a tread and a profile by numbers: treads exist only for barrels.
    #[error(
        "wheel `{wheel}`: its rollers have a profile by numbers and a tread, which only barrels can have; make them barrels with a \
         crown, or leave the tread out"
    )]
    TreadOnTurned {
        /// The wheel's name.
        wheel: String,
    },
    /// Rollers should have play with the shapes of their file or a profile by numbers: their
    /// contacts are like those with a tread.
    #[error(
        "wheel `{wheel}`: its rollers have play along their axles, which only barrels can have; take barrels, with a crown or without, or \
         leave the play out"
    )]
    PlayOfNoBarrel {
        /// The wheel's name.
        wheel: String,
    },
    /// An implausible play along the axles of rollers.
    #[error(
        "wheel `{wheel}`: its rollers have a play of {play_m} m along their axles; write one in metres from 0 to their radius, \
         {most_m} m: 0.2 mm is 0.0002"
    )]
    NoSuchPlay {
        /// The wheel's name.
        wheel: String,
        /// The play, in metres.
        play_m: f64,
        /// Smallest radius of the wheel's rollers, in metres.
        most_m: f64,
    },
    /// Friction on an axle without radius, or thicker than the rollers on it.
    #[error(
        "wheel `{wheel}`: its rollers have friction of coefficient {friction} on axles of radius {axle_m} m; write a coefficient of 0 or more, and a \
         radius in metres above 0 and below that of the rollers, {most_m} m: 2 mm is 0.002"
    )]
    NoSuchAxle {
        /// The wheel's name.
        wheel: String,
        /// The coefficient of friction.
        friction: f64,
        /// The radius of the axles, in metres.
        axle_m: f64,
        /// Smallest radius of the wheel's rollers, in metres.
        most_m: f64,
    },
    /// A tread so soft that the robot's weight alone would compress it by more than its rollers'
    /// radius.
    #[error(
        "wheel `{wheel}`: its tread of {stiffness_n_m} N/m would be pressed by {sag_mm:.1} mm under its share of the weight, deeper than its \
         rollers' radius of {radius_mm:.1} mm; give it {least_n_m:.0} N/m or more"
    )]
    TreadTooSoft {
        /// The wheel's name.
        wheel: String,
        /// The tread's stiffness along the normal, in N/m.
        stiffness_n_m: f64,
        /// Its deflection, in millimetres.
        sag_mm: f64,
        /// Smallest radius of the wheel's rollers, in millimetres.
        radius_mm: f64,
        /// The stiffness at which the deflection equals that radius, in N/m.
        least_n_m: f64,
    },
}
