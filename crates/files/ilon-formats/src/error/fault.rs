//! The faults of robot files.

use super::clue::Clues;
use super::lists::{above_floor, counted, left_out_of, listed, looked_at, missing};
use super::named::{CandidateJoint, MissingFile};
use crate::options::WheelOptions;

/// What is wrong with a robot's description.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The file cannot be read.
    #[error("cannot be read: {reason}")]
    Unreadable {
        /// What the operating system said.
        reason: String,
    },
    /// The description is not TOML, or not of the form that [`crate::Spec`] has.
    #[error("{reason}")]
    Toml {
        /// What the parser said.
        reason: String,
    },
    /// Keys of a description are given for a file that is none.
    #[error(
        "it is no description in TOML, whose keys {} could be changed",
        listed(keys)
    )]
    NotADescription {
        /// The first part of each key.
        keys: Vec<String>,
    },
    /// More joints turn as wheels do than a robot has.
    #[error("{count} joints turn as wheels do, and a robot of more than {most} wheels is not read")]
    TooManyWheels {
        /// How many.
        count: usize,
        /// How many are read.
        most: usize,
    },
    /// A value of the description is out of its range.
    #[error("`{key}` is {value}, but must be {range}")]
    OutOfRange {
        /// The key in the description.
        key: String,
        /// Its value.
        value: String,
        /// The range it must lie in.
        range: &'static str,
    },
    /// A wheel of the description is not there.
    #[error("there is no wheel `{wheel}`; there are {}", listed(wheels))]
    NoSuchWheel {
        /// The wheel.
        wheel: String,
        /// The wheels that there are.
        wheels: Vec<String>,
    },
    /// The rollers are too slender to reach one another.
    #[error(
        "rollers of {roller_radius_mm:.2} mm radius taper to nothing before they reach their neighbours"
    )]
    RollersTooSlender {
        /// The largest radius of the roller, in millimetres.
        roller_radius_mm: f64,
        /// The least radius with which the end sphere keeps a positive radius, in millimetres.
        least_radius_mm: f64,
    },

    /// The text is not well-formed XML.
    #[error("{}{reason}", if reason.contains("DTD") { "" } else { "not well-formed XML: " })]
    Xml {
        /// What the parser said.
        reason: String,
    },
    /// The root element is that of no format that is read.
    #[error("its root element is `<{root_tag}>`, where `<robot>`, `<sdf>` or `<mujoco>` is read")]
    NotUrdf {
        /// The tag of the root element.
        root_tag: String,
    },
    /// A xacro file cannot be expanded.
    #[error(
        "it cannot be expanded: {reason}{}",
        if *before_2014 { "; elements of it stand without the prefix `xacro:`, as until 2014" } else { "" }
    )]
    Xacro {
        /// Why not.
        reason: String,
        /// Whether elements stand without the prefix `xacro:`, as until 2014: a repair reads them.
        before_2014: bool,
    },
    /// Files that a xacro file includes, or packages that they lie in, are not there.
    #[error("{}", missing(files))]
    MissingFiles {
        /// All of them.
        files: Vec<MissingFile>,
    },
    /// An argument of a xacro file has neither value nor default.
    #[error("the argument `{name}` has neither value nor default")]
    MissingArgument {
        /// Its name.
        name: String,
        /// Whether the robot was found to be the same with each of some values.
        any_does: bool,
    },
    /// A xacro file defines macros and makes no link.
    #[error(
        "it defines macros and makes no link: {}{}",
        listed(macros),
        if callers.is_empty() { String::new() } else { format!("; {} beside it includes it", listed(callers)) }
    )]
    MacrosOnly {
        /// The macros that are never called.
        macros: Vec<String>,
        /// Files beside it that include it.
        callers: Vec<String>,
    },
    /// A xacro file is written as it was until 2014, when its elements had no prefix.
    #[error("a xacro file of before 2014: `<{tag}>` stands without the prefix `xacro:`")]
    OldXacro {
        /// The tag of the first such element.
        tag: String,
    },
    /// SDF or MJCF that says something which has no counterpart here.
    #[error("{reason}")]
    Format {
        /// What.
        reason: String,
    },
    /// The file is larger than anything that is read.
    #[error("too large to be read: {what}, where at most {most} are read")]
    TooLarge {
        /// What there is too much of.
        what: String,
        /// The most that is read.
        most: String,
    },
    /// urdf-rs cannot read the file.
    #[error("{reason}")]
    Urdf {
        /// What urdf-rs said.
        reason: String,
    },
    /// An attribute is missing.
    #[error("the attribute `{attribute}` is missing")]
    MissingAttribute {
        /// Its name.
        attribute: String,
    },
    /// A child element is missing.
    #[error("the element `<{child}>` is missing")]
    MissingElement {
        /// Its tag.
        child: &'static str,
    },
    /// Two links, or two joints, have the same name.
    #[error("the name is taken by the {tag} on line {first_line}")]
    DuplicateName {
        /// `link` or `joint`.
        tag: &'static str,
        /// Where the first of them stands.
        first_line: usize,
    },
    /// An attribute does not hold the numbers it should.
    #[error("`{attribute}=\"{value}\"` does not hold {}", counted(*count, "number"))]
    NotNumbers {
        /// Its name.
        attribute: String,
        /// Its text.
        value: String,
        /// How many numbers it should hold.
        count: usize,
    },
    /// An attribute holds NaN or infinity.
    #[error("`{attribute}=\"{value}\"` is not finite")]
    NotFinite {
        /// Its name.
        attribute: String,
        /// Its text.
        value: String,
    },
    /// An inertia has a principal moment of zero or below.
    #[error(
        "the inertia has the principal moment {least:.3e} kg m^2, but a body with mass has three above 0"
    )]
    InertiaNotPositive {
        /// The least principal moment, in kg m^2.
        least: f64,
    },
    /// No distribution of mass has such an inertia.
    #[error(
        "no body has the principal moments {least:.3e}, {middle:.3e} and {most:.3e} kg m^2: the largest exceeds the sum \
         of the others"
    )]
    InertiaImpossible {
        /// The least principal moment, in kg m^2.
        least: f64,
        /// The middle one, in kg m^2.
        middle: f64,
        /// The largest, in kg m^2.
        most: f64,
    },
    /// A collision has a geometry that URDF does not know, or none.
    #[error("holds none of box, cylinder, capsule, sphere and mesh")]
    UnknownGeometry,
    /// A joint has a type that URDF does not know.
    #[error("`{joint_type}` is not a type of joint")]
    UnknownJointType {
        /// The type.
        joint_type: String,
    },
    /// A joint names a link that is not there.
    #[error("there is no link `{link}`")]
    UnknownLink {
        /// The name.
        link: String,
    },
    /// The axis of a joint has no direction.
    #[error("the axis is zero and has no direction")]
    ZeroAxis,
    /// A link is the child of two joints.
    #[error("its child `{link}` already hangs by joint `{first_joint}`")]
    TwoParents {
        /// The link.
        link: String,
        /// The first joint that has it as its child.
        first_joint: String,
    },
    /// Links hang by one another in a circle.
    #[error("the links hang by one another in a loop")]
    Loop,
    /// Several links hang by nothing.
    #[error("{} links hang by no joint: {}", links.len(), listed(links))]
    SeveralRoots {
        /// Their names.
        links: Vec<String>,
    },
    /// A body that moves has no mass.
    #[error("neither it nor anything fixed to it has mass and inertia")]
    NoMass,
    /// A joint between bodies cannot be as it shall be.
    #[error("{reason}")]
    JointRole {
        /// What is wrong, and what to do.
        reason: String,
    },
    /// The inertia of a body is far too large for its mass and size.
    #[error(
        "with {mass_kg:.4} kg its inertia has a radius of gyration of {gyration_m:.3} m, but nothing of it reaches further \
         than {reach_m:.3} m"
    )]
    InertiaTooLarge {
        /// Its mass, in kg.
        mass_kg: f64,
        /// sqrt(I / m) of its largest principal moment, in metres.
        gyration_m: f64,
        /// How far it reaches from its centre of mass, in metres.
        reach_m: f64,
    },
    /// The inertia of a body is next to nothing for its mass and shapes.
    #[error(
        "with {mass_kg:.4} kg its inertia has a radius of gyration of {:.3} mm, where a solid of its shape has {:.1} mm",
        1e3 * gyration_m, 1e3 * solid_m
    )]
    InertiaTooSmall {
        /// Its mass, in kg.
        mass_kg: f64,
        /// sqrt(I / m) of its largest principal moment, in metres.
        gyration_m: f64,
        /// The same of a solid of its shape, in metres.
        solid_m: f64,
    },
    /// The moments of inertia of a body are those of its shape about other axes.
    #[error(
        "its moments are those of its shape about other axes: ixx, iyy and izz may be exchanged, or its frame be turned"
    )]
    InertiaExchanged,
    /// A wheel's moment about its own axle is much less than that across it, as of no wheel that is rounder than long.
    #[error(
        "its moment about the wheel's axle is {axial_kg_m2:.2e} kg m^2, that across it {across_kg_m2:.2e}, where a disc has more about its axle: \
         ixx, iyy and izz may be exchanged, or a power of ten be missing"
    )]
    InertiaThinAboutAxle {
        /// About its axle, in kg m^2.
        axial_kg_m2: f64,
        /// Across it, in kg m^2: the mean of both.
        across_kg_m2: f64,
    },
    /// The robot has fewer than three wheels.
    #[error(
        "{} with passive rollers{}, but moving freely in the plane takes three{}{has}",
        counted(wheels.len(), "wheel"),
        if wheels.is_empty() { String::new() } else { format!(": {}", listed(wheels)) },
        looked_at(looked)
    )]
    TooFewWheels {
        /// The joints of the wheels that were found.
        wheels: Vec<String>,
        /// The joints that were looked at, and why they are no wheels.
        looked: Vec<CandidateJoint>,
        /// What a file without a single wheel has, in words.
        has: String,
    },
    /// The robot has wheels, but they carry no rollers.
    #[error(
        "{} without rollers: {}{}",
        counted(wheels.len(), "wheel"), listed(wheels), left_out_of(left_out)
    )]
    NoRollers {
        /// Their joints.
        wheels: Vec<String>,
        /// Rollers that fit how they stand and what the file says of them.
        rollers: Proposed,
        /// What speaks for these and which of their numbers are assumed, or what hints at some without being enough, in words.
        why: Option<String>,
        /// Joints that are called wheels or turn like some and are not among these, and why.
        left_out: Vec<CandidateJoint>,
    },
    /// The robot has steered wheels.
    #[error(
        "{} on upright joints: {}{}. These are not Swedish wheels",
        counted(wheels.len(), "steered wheel"), listed(wheels), left_out_of(left_out)
    )]
    Steered {
        /// Their joints.
        wheels: Vec<String>,
        /// Rollers that fit how they stand with the upright joints held.
        rollers: Proposed,
        /// Joints that are called wheels or turn like some and are not among these, and why.
        left_out: Vec<CandidateJoint>,
    },
    /// A joint carries rollers, but does not turn.
    #[error(
        "carries {rollers} passive rollers, but does not turn; without it the robot has {wheels} wheel(s), but moving \
         freely in the plane takes three"
    )]
    HubDoesNotTurn {
        /// How many rollers it carries.
        rollers: usize,
        /// How many wheels the robot has without it.
        wheels: usize,
    },
    /// Wheels carry rollers that do not turn.
    #[error(
        "the {rollers} rollers of {} do not turn: their joints are fixed",
        listed(wheels)
    )]
    RollersDoNotTurn {
        /// How many rollers there are on a wheel.
        rollers: usize,
        /// The wheels' joints.
        wheels: Vec<String>,
    },
    /// The chassis reaches down to the floor on which the wheels stand, or below it.
    #[error(
        "its collision geometry {}, at x = {:.3} m, y = {:.3} m",
        above_floor(*deep_mm), at_m[0], at_m[1]
    )]
    ChassisBelowFloor {
        /// How far, in millimetres; below 0 of one that stands less above it than the first bump or a tread gives.
        deep_mm: f64,
        /// Where, in the body frame, in metres.
        at_m: [f64; 2],
    },
    /// A roller's axis is parallel to its hub's.
    #[error("gamma = 90 deg: the roller turns about the hub axis, and the wheel cannot drive")]
    GammaRightAngle,
    /// A hub axis leans out of the ground plane.
    #[error("the hub axis leans {lean_deg:.1} deg out of the ground plane")]
    HubNotLevel {
        /// How far, in degrees.
        lean_deg: f64,
    },
    /// A roller has no collision geometry.
    #[error("the roller has no collision geometry, so that its size is not known")]
    RollerWithoutShape,
    /// A roller's collision geometry is not round about its axis.
    #[error("the roller's collision geometry is not round about its axis")]
    RollerNotRound,
    /// A mesh cannot be read.
    #[error("its mesh `{mesh}` cannot be read: {reason}")]
    MeshUnreadable {
        /// The mesh's file.
        mesh: String,
        /// Why not.
        reason: String,
    },
    /// The folder of a ROS package is not known.
    #[error("its mesh `{mesh}` lies in the package `{package}`, whose folder is not known")]
    PackageUnknown {
        /// The package.
        package: String,
        /// The mesh as the file names it.
        mesh: String,
    },
    /// An element names a joint that is not there.
    #[error("there is no joint `{joint}`")]
    UnknownJoint {
        /// The joint.
        joint: String,
        /// The joint of the file whose name is most like it.
        near: Option<String>,
    },
    /// A joint that should be a wheel is not there.
    #[error(
        "there is no joint `{joint}`{}{}",
        if likely.is_empty() { String::new() } else { format!("; wheels could be {}", listed(likely)) },
        if likely.is_empty() { looked_at(looked) } else { String::new() }
    )]
    NoSuchJoint {
        /// The joint.
        joint: String,
        /// The joints that could be wheels.
        likely: Vec<String>,
        /// The joints that were looked at, and why they are no wheels.
        looked: Vec<CandidateJoint>,
    },
    /// A joint that should be a wheel cannot be one.
    #[error("it cannot be taken for a wheel: {reason}")]
    NotAWheel {
        /// Why not.
        reason: String,
    },
    /// A joint that should be given rollers has some.
    #[error("it has rollers in the file already")]
    HasRollers,
    /// The radius of a wheel is not known: of one that is given rollers, or one whose rollers have no geometry.
    #[error("the wheel's geometry does not show its radius{}", reason.as_ref().map_or(String::new(), |r| format!(": {r}")))]
    WheelSizeUnknown {
        /// Why its geometry does not.
        reason: Option<String>,
        /// What else in the file speaks for a radius.
        clues: Box<Clues>,
        /// The package that its geometry lies in, where that package's folder is not known.
        package: Option<String>,
    },
    /// The usual X is asked for, but the wheels do not stand in it.
    #[error(
        "the usual X arrangement has parallel hub axes and wheels off both middle lines: here {what}"
    )]
    NotInX {
        /// What is otherwise.
        what: &'static str,
    },
    /// A roller differs from the others of its wheel.
    #[error("{quantity} is {this} at this roller and {others} on average over its wheel")]
    RollersDiffer {
        /// The quantity.
        quantity: &'static str,
        /// Its value at this roller.
        this: String,
        /// Its mean over the wheel.
        others: String,
    },
    /// Rollers cannot be made as the file says.
    #[error("the rollers cannot be made so: {reason}")]
    RollersNotMade {
        /// What is wrong.
        reason: String,
    },
    /// A wheel has angles at which no roller touches the ground.
    #[error(
        "the rollers leave gaps of up to {widest_gap_deg:.2} deg, {share_percent:.1} % of the turn, over which the wheel \
         falls between them{}",
        if *missing > 0 { format!(": by their places {missing} of {of} are missing in the file") } else { String::new() }
    )]
    RollersHaveGaps {
        /// The widest gap, in degrees of the wheel's turn.
        widest_gap_deg: f64,
        /// The share of a turn without a roller, in per cent.
        share_percent: f64,
        /// How many rollers are missing of an even ring, by the places of the others.
        missing: usize,
        /// How many such a ring has.
        of: usize,
        /// Whether the wheel could roll over the gaps as its file models it.
        rolls: bool,
    },
    /// Wheels do not stand on one floor.
    #[error(
        "it ends {apart_mm:.2} mm above the lowest wheel; {}; up to {most_deg} deg are taken",
        if gap_mm > &0.0 {
            format!("{gap_mm:.2} mm are left between it and the floor that the others stand on")
        } else {
            format!("the robot leans {tilt_deg:.1} deg on its wheels")
        }
    )]
    UnevenWheels {
        /// How much higher than the lowest wheel this one ends in the frame of the root link, in millimetres.
        apart_mm: f64,
        /// How far the robot leans, in degrees.
        tilt_deg: f64,
        /// How high above the floor this wheel hangs, in millimetres; 0 where it stands on it.
        gap_mm: f64,
        /// The largest lean that is taken, in degrees.
        most_deg: f64,
    },
    /// A wheel is so large that the file must be in millimetres.
    #[error("the wheel has a radius of {radius_m:.1} m")]
    LooksLikeMillimetres {
        /// Its radius, in metres.
        radius_m: f64,
    },
}

/// Rollers that a file speaks for.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Proposed {
    /// These fit how the wheels stand and what is said of them.
    Rollers(Box<WheelOptions>),
    /// What the wheels are called contradicts how they stand.
    Contradiction,
    /// Nothing says that the wheels carry rollers: they may be plain ones.
    NothingSaid,
}
