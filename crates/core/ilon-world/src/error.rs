//! What can be wrong with a world before it starts.

/// Why a world could not be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A setting lies outside its range.
    #[error("{name} is {value}, but must be {range}")]
    Setting {
        /// The setting's name.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The range that is valid.
        range: &'static str,
    },
    /// The robot cannot begin where it is put: boxes or bumps of the ground are in its way.
    #[error(
        "the robot cannot stand where it starts: put down there, {reason}; start it elsewhere, or move what is in its way"
    )]
    NoPlaceToStand {
        /// What would be wrong.
        reason: String,
    },
    /// Something that rapier's own solver of contacts does not know.
    #[error("contacts that rapier solves cannot have {what}; let ilon solve them, or {remedy}")]
    NotInRapier {
        /// What it does not know.
        what: String,
        /// What to do without it.
        remedy: &'static str,
    },
    /// A joint between bodies that cannot be simulated.
    #[error("joint `{joint}`: {reason}")]
    Joint {
        /// The joint's name.
        joint: String,
        /// What is wrong, and what to do.
        reason: String,
    },
    /// A free body that cannot be, or cannot begin where it is put.
    #[error("body `{name}`: {reason}")]
    FreeBody {
        /// The body's name.
        name: String,
        /// What is wrong, and what to do.
        reason: String,
    },
    /// A world shall have no robot.
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
    /// A roller's barrel has no end: its profile reaches the axis before the roller does.
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
    /// A roller shall have the shapes of its file, but one of them is a mesh without volume.
    #[error(
        "wheel `{wheel}`: roller `{roller}` has a collision mesh without volume; take barrels, or mend the mesh"
    )]
    FlatRoller {
        /// The wheel's name.
        wheel: String,
        /// The roller's name.
        roller: String,
    },
    /// Rollers shall have a tread and the shapes of their file: a tread is known of barrels only.
    #[error(
        "wheel `{wheel}`: its rollers have the shapes of their file and a tread, which only barrels can have; take barrels, or \
         leave the tread out"
    )]
    TreadOnModelled {
        /// The wheel's name.
        wheel: String,
    },
    /// Rollers shall have the shapes of their file where rolling costs something, or floors creep: how their place of contact moves is known of
    /// shapes by numbers only.
    #[error(
        "wheel `{wheel}`: its rollers have the shapes of their file, of which rolling resistance and creep are not known; take barrels, or \
         leave the floor's and the rollers' rolling resistance and the creep out"
    )]
    DragOnModelled {
        /// The wheel's name.
        wheel: String,
    },
    /// Rollers shall have a tread and a profile by numbers: a tread is known of barrels only.
    #[error(
        "wheel `{wheel}`: its rollers have a profile by numbers and a tread, which only barrels can have; make them barrels with a \
         crown, or leave the tread out"
    )]
    TreadOnTurned {
        /// The wheel's name.
        wheel: String,
    },
    /// Rollers shall have play, and the shapes of their file or a profile by numbers: they touch as those with a tread do.
    #[error(
        "wheel `{wheel}`: its rollers have play along their axles, which only barrels can have; take barrels, with a crown or without, or \
         leave the play out"
    )]
    PlayOfNoBarrel {
        /// The wheel's name.
        wheel: String,
    },
    /// Play along the axles of rollers that no bearing has.
    #[error(
        "wheel `{wheel}`: its rollers have a play of {play_m} m along their axles; write one in metres from 0 to their radius, \
         {most_m} m: 0.2 mm is 0.0002"
    )]
    NoSuchPlay {
        /// The wheel's name.
        wheel: String,
        /// The play, in metres.
        play_m: f64,
        /// The least radius of the wheel's rollers, in metres.
        most_m: f64,
    },
    /// There is friction on an axle that has no radius, or is thicker than the rollers on it.
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
        /// The least radius of the wheel's rollers, in metres.
        most_m: f64,
    },
    /// A tread is so soft that the robot's weight alone would press it deeper than its rollers are thick.
    #[error(
        "wheel `{wheel}`: its tread of {stiffness_n_m} N/m would be pressed by {sag_mm:.1} mm under its share of the weight, deeper than its \
         rollers' radius of {radius_mm:.1} mm; give it {least_n_m:.0} N/m or more"
    )]
    TreadTooSoft {
        /// The wheel's name.
        wheel: String,
        /// The tread's stiffness along the normal, in N/m.
        stiffness_n_m: f64,
        /// How deep it would be pressed, in millimetres.
        sag_mm: f64,
        /// The least radius of the wheel's rollers, in millimetres.
        radius_mm: f64,
        /// The stiffness at which it is pressed by that radius, in N/m.
        least_n_m: f64,
    },
}
