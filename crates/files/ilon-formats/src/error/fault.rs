//! The faults of robot files.

use super::clue::Clues;
use super::help::{
    BOX, DESCRIPTIONS, LONGER_ROLLERS, ROLLERS_APART, WHEELS, WHEELS_ON_TYRES, of_element,
    of_reading, of_rollers, of_xacro, of_xml,
};
use super::lists::{above_floor, counted, left_out_of, listed, looked_at, mass_words, missing};
use super::named::{CandidateJoint, MissingFile, Proposed};

/// A fault of a robot's description.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum Fault {
    /// The file cannot be read.
    #[error("cannot be read: {reason}")]
    #[diagnostic(help("{}", of_reading(reason)))]
    Unreadable {
        /// The operating system's message.
        reason: String,
    },
    /// The description is not TOML, or does not have the form of [`crate::Spec`].
    #[error("{reason}")]
    #[diagnostic(help("{}", if help.is_empty() { DESCRIPTIONS } else { help.as_str() }))]
    Toml {
        /// What is wrong.
        reason: String,
        /// How to repair a key; empty for a text that is not TOML.
        help: String,
    },
    /// Keys of a description are set for a file that is not a description.
    #[error(
        "it is no description in TOML, whose keys {} could be changed",
        listed(keys)
    )]
    #[diagnostic(help(
        "name the description from which the robot is generated, or leave these keys out"
    ))]
    NotADescription {
        /// The first part of each key.
        keys: Vec<String>,
    },
    /// More joints turn like wheels than are supported.
    #[error("{count} joints turn as wheels do, and a robot of more than {most} wheels is not read")]
    #[diagnostic(help(
        "write type=\"fixed\" for joints that do not turn, or read a file of one robot"
    ))]
    TooManyWheels {
        /// Their number.
        count: usize,
        /// The limit.
        most: usize,
    },
    /// A value of the description is out of its range.
    #[error("`{key}` is {value}, but must be {range}")]
    #[diagnostic(help("make `{key}` {range}"))]
    OutOfRange {
        /// The key in the description.
        key: String,
        /// The value.
        value: String,
        /// The allowed range.
        range: &'static str,
    },
    /// An unknown wheel of the description.
    #[error("there is no wheel `{wheel}`; there are {}", listed(wheels))]
    #[diagnostic(help("name a wheel that the description has"))]
    NoSuchWheel {
        /// The key that names it.
        key: String,
        /// The name.
        wheel: String,
        /// The existing wheels.
        wheels: Vec<String>,
    },
    /// The rollers are too slender to reach one another.
    #[error(
        "rollers of {roller_radius_mm:.2} mm radius taper to nothing before they reach their neighbours"
    )]
    #[diagnostic(help(
        "make the rollers thicker than {least_radius_mm:.2} mm, or use more of them"
    ))]
    RollersTooSlender {
        /// The key of their radius; empty for wheels that are given rollers.
        key: String,
        /// The largest radius of the roller, in millimetres.
        roller_radius_mm: f64,
        /// The smallest radius for which the end sphere keeps a positive radius, in millimetres.
        least_radius_mm: f64,
    },

    /// The text is not well-formed XML.
    #[error("{}{reason}", if reason.contains("DTD") { "" } else { "not well-formed XML: " })]
    #[diagnostic(help("{}", of_xml(reason)))]
    Xml {
        /// The parser's message.
        reason: String,
    },
    /// The root element belongs to no supported format.
    #[error("its root element is `<{root_tag}>`, where `<robot>`, `<sdf>` or `<mujoco>` is read")]
    #[diagnostic(help("give a URDF, xacro, SDF or MJCF file, or a description in TOML"))]
    NotUrdf {
        /// The tag of the root element.
        root_tag: String,
    },
    /// A xacro file cannot be expanded.
    #[error(
        "it cannot be expanded: {reason}{}",
        if *before_2014 { "; elements of it stand without the prefix `xacro:`, as until 2014" } else { "" }
    )]
    #[diagnostic(help("{}", of_xacro(reason)))]
    Xacro {
        /// The reason.
        reason: String,
        /// Whether elements lack the prefix `xacro:`, as until 2014: a repair accepts them.
        before_2014: bool,
    },
    /// Missing files that a xacro file includes, or missing packages of them.
    #[error("{}", missing(files))]
    #[diagnostic(help("{}, or go without them", if files.iter().any(|file| file.package.is_some()) { "say where the packages lie" } else { "put the files there" }))]
    MissingFiles {
        /// All of them.
        files: Vec<MissingFile>,
    },
    /// An argument of a xacro file has neither value nor default.
    #[error("the argument `{name}` has neither value nor default")]
    #[diagnostic(help("give `{name}` a value, or a default where it is declared{}", if *any_does { "; whatever it is, the robot is the same" } else { "" }))]
    MissingArgument {
        /// Its name.
        name: String,
        /// Whether the robot is the same for all tested values.
        any_does: bool,
    },
    /// A xacro file that only defines macros, without a link.
    #[error(
        "it defines macros and makes no link: {}{}",
        listed(macros),
        if callers.is_empty() { String::new() } else { format!("; {} includes it", listed(callers)) }
    )]
    #[diagnostic(help("give the file that calls them"))]
    MacrosOnly {
        /// The macros that are never called.
        macros: Vec<String>,
        /// Files that include it, in its folder or in those beside it.
        callers: Vec<String>,
    },
    /// A xacro file in the syntax until 2014, without the prefix.
    #[error("a xacro file of before 2014: `<{tag}>` stands without the prefix `xacro:`")]
    #[diagnostic(help(
        "write `<xacro:include>`, `<xacro:property>`, `<xacro:macro>` and `<xacro:...>` for each call of a macro"
    ))]
    OldXacro {
        /// The tag of the first such element.
        tag: String,
    },
    /// SDF or MJCF with an unsupported feature.
    #[error("{reason}")]
    #[diagnostic(help("{}", if reason.contains("<mujocoinclude>") { "give the file that includes it" } else { "change the file, or convert it to URDF" }))]
    Format {
        /// Its description.
        reason: String,
    },
    /// The file exceeds a limit.
    #[error("too large to be read: {what}, where at most {most} are read")]
    #[diagnostic(help("give a smaller file"))]
    TooLarge {
        /// The quantity.
        what: String,
        /// The limit.
        most: String,
    },
    /// urdf-rs rejects the file.
    #[error("{reason}")]
    #[diagnostic(help("compare with the URDF specification, http://wiki.ros.org/urdf/XML"))]
    Urdf {
        /// Its message.
        reason: String,
    },
    /// An attribute is missing.
    #[error("the attribute `{attribute}` is missing")]
    #[diagnostic(help("add `{attribute}=\"...\"` to the element"))]
    MissingAttribute {
        /// Its name.
        attribute: String,
    },
    /// A child element is missing.
    #[error("the element `<{child}>` is missing")]
    #[diagnostic(help("{}", of_element(child)))]
    MissingElement {
        /// Its tag.
        child: &'static str,
    },
    /// Two links, or two joints, have the same name.
    #[error("the name is taken by the {tag} on line {first_line}")]
    #[diagnostic(help("give each link and each joint a name of its own"))]
    DuplicateName {
        /// `link` or `joint`.
        tag: &'static str,
        /// Line of the first of them.
        first_line: usize,
    },
    /// An attribute does not contain the required numbers.
    #[error("`{attribute}=\"{value}\"` does not hold {}", counted(*count, "number"))]
    #[diagnostic(help("write {}", if *count == 1 { "a number".to_owned() } else { format!("{count} numbers, separated by spaces") }))]
    NotNumbers {
        /// Its name.
        attribute: String,
        /// Its text.
        value: String,
        /// The required number of values.
        count: usize,
    },
    /// An attribute holds NaN or infinity.
    #[error("`{attribute}=\"{value}\"` is not finite")]
    #[diagnostic(help("write a finite number; a limit that does not exist is left out"))]
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
    #[diagnostic(help("take the inertia from a CAD program, or {}", BOX))]
    InertiaNotPositive {
        /// The smallest principal moment, in kg m^2.
        least: f64,
    },
    /// No distribution of mass has such an inertia.
    #[error(
        "no body has the principal moments {least:.3e}, {middle:.3e} and {most:.3e} kg m^2: the largest exceeds the sum \
         of the others"
    )]
    #[diagnostic(help("take the inertia from a CAD program, or {}", BOX))]
    InertiaImpossible {
        /// The smallest principal moment, in kg m^2.
        least: f64,
        /// The middle one, in kg m^2.
        middle: f64,
        /// The largest, in kg m^2.
        most: f64,
    },
    /// A collision with a missing geometry, or one unknown to URDF.
    #[error("holds none of box, cylinder, capsule, sphere and mesh")]
    #[diagnostic(help("give the collision one of these geometries"))]
    UnknownGeometry,
    /// A joint with a type unknown to URDF.
    #[error("`{joint_type}` is not a type of joint")]
    #[diagnostic(help(
        "use `continuous` for wheels and rollers and `fixed` for what does not move"
    ))]
    UnknownJointType {
        /// The type.
        joint_type: String,
    },
    /// A joint that names a missing link.
    #[error("there is no link `{link}`")]
    #[diagnostic(help("add the link, or correct its name here"))]
    UnknownLink {
        /// The name.
        link: String,
    },
    /// The axis of a joint has no direction.
    #[error("the axis is zero and has no direction")]
    #[diagnostic(help("give the axis a direction, such as `<axis xyz=\"0 1 0\"/>`"))]
    ZeroAxis,
    /// A link is the child of two joints.
    #[error("its child `{link}` already hangs by joint `{first_joint}`")]
    #[diagnostic(help("remove one of the joints: a URDF is a tree"))]
    TwoParents {
        /// The link.
        link: String,
        /// The first joint that has it as its child.
        first_joint: String,
    },
    /// Links form a loop.
    #[error("the links hang by one another in a loop")]
    #[diagnostic(help("remove one joint of the loop: a URDF is a tree with one root"))]
    Loop,
    /// Several links without a parent.
    #[error("{} links hang by no joint: {}", links.len(), listed(links))]
    #[diagnostic(help(
        "join them by fixed joints, so that one root is left, or remove what does not belong"
    ))]
    SeveralRoots {
        /// Their names.
        links: Vec<String>,
    },
    /// A moving body without mass.
    #[error("neither it nor anything fixed to it has mass and inertia")]
    #[diagnostic(help("add an `<inertial>` with mass and inertia"))]
    NoMass,
    /// A joint between bodies cannot have the requested role.
    #[error("{reason}")]
    #[diagnostic(help(
        "a joint between bodies may be `free`, `sprung` with a stiffness, `driven` by a servo, or `held`"
    ))]
    JointRole {
        /// The reason, with a remedy.
        reason: String,
    },
    /// The inertia of a body is far too large for its mass and size.
    #[error(
        "with {} its inertia has a radius of gyration of {gyration_m:.3} m, but nothing of it reaches further \
         than {reach_m:.3} m",
        mass_words(*mass_kg)
    )]
    #[diagnostic(help("take the inertia from a CAD program, or {}", BOX))]
    InertiaTooLarge {
        /// Its mass, in kg.
        mass_kg: f64,
        /// sqrt(I / m) of its largest principal moment, in metres.
        gyration_m: f64,
        /// Its largest distance from the centre of mass, in metres.
        reach_m: f64,
    },
    /// The inertia of a body is far too small for its mass and shapes.
    #[error(
        "with {} its inertia has a radius of gyration of {:.3} mm, where a solid of its shape has {:.1} mm",
        mass_words(*mass_kg), 1e3 * gyration_m, 1e3 * solid_m
    )]
    #[diagnostic(help("take the inertia from a CAD program, or {}", BOX))]
    InertiaTooSmall {
        /// Its mass, in kg.
        mass_kg: f64,
        /// sqrt(I / m) of its largest principal moment, in metres.
        gyration_m: f64,
        /// The same for a solid of its shape, in metres.
        solid_m: f64,
    },
    /// The moments of inertia of a body match its shape about other axes.
    #[error(
        "its moments are those of its shape about other axes: ixx, iyy and izz may be exchanged, or its frame be turned"
    )]
    #[diagnostic(help("take the inertia from a CAD program, or {}", BOX))]
    InertiaExchanged,
    /// A wheel's moment about its own axle is much less than across it, unlike any wheel that is
    /// wider than long.
    #[error(
        "its moment about the wheel's axle is {axial_kg_m2:.2e} kg m^2, that across it {across_kg_m2:.2e}, where a disc has more about its axle: \
         ixx, iyy and izz may be exchanged, or a power of ten be missing"
    )]
    #[diagnostic(help("take the inertia from a CAD program, or {}", BOX))]
    InertiaThinAboutAxle {
        /// Moment about its axle, in kg m^2.
        axial_kg_m2: f64,
        /// Mean moment across it, in kg m^2.
        across_kg_m2: f64,
    },
    /// The robot has fewer than three wheels, or than two on tyres.
    #[error(
        "{} {}{}, but {}{}{has}",
        counted(wheels.len(), "wheel"),
        if *on_tyres { "to roll on a tyre" } else { "with passive rollers" },
        if wheels.is_empty() { String::new() } else { format!(": {}", listed(wheels)) },
        if *on_tyres { "driving and turning takes two" } else { "moving freely in the plane takes three" },
        looked_at(looked)
    )]
    #[diagnostic(help("{}", if *on_tyres { WHEELS_ON_TYRES } else { WHEELS }))]
    TooFewWheels {
        /// The joints of the wheels found.
        wheels: Vec<String>,
        /// The other joints, with the reasons why they are no wheels.
        looked: Vec<CandidateJoint>,
        /// A summary of a file without a single wheel.
        has: String,
        /// Whether its wheels roll on tyres.
        on_tyres: bool,
    },
    /// The robot has wheels without rollers.
    #[error(
        "{} without rollers: {}{}",
        counted(wheels.len(), "wheel"), listed(wheels), left_out_of(left_out)
    )]
    #[diagnostic(help("{}", of_rollers(rollers, why.as_deref())))]
    NoRollers {
        /// Their joints.
        wheels: Vec<String>,
        /// Rollers that match the wheels' arrangement and the file's information.
        rollers: Proposed,
        /// The evidence for them and the assumed numbers, or insufficient hints, as text.
        why: Option<String>,
        /// Joints that are named like wheels or turn like wheels and are not among these, with
        /// reasons.
        left_out: Vec<CandidateJoint>,
    },
    /// The robot has steered wheels.
    #[error(
        "{} on upright joints: {}{}. These are not Swedish wheels",
        counted(wheels.len(), "steered wheel"), listed(wheels), left_out_of(left_out)
    )]
    #[diagnostic(help(
        "let them roll on tyres; or if these stand for Swedish wheels, name them: their upright joints are held, and rollers are put in"
    ))]
    Steered {
        /// Their joints.
        wheels: Vec<String>,
        /// Rollers that match the wheels' arrangement with the upright joints locked.
        rollers: Proposed,
        /// Joints that are named like wheels or turn like wheels and are not among these, with
        /// reasons.
        left_out: Vec<CandidateJoint>,
    },
    /// A joint with rollers that does not turn.
    #[error(
        "carries {rollers} passive rollers, but does not turn; without it the robot has {wheels} wheel(s), but moving \
         freely in the plane takes three"
    )]
    #[diagnostic(help("make the joint `continuous`, with the hub's axis"))]
    HubDoesNotTurn {
        /// The number of its rollers.
        rollers: usize,
        /// The number of the robot's other wheels.
        wheels: usize,
    },
    /// Wheels carry rollers that do not turn.
    #[error(
        "the {rollers} rollers of {} do not turn: their joints are fixed",
        listed(wheels)
    )]
    #[diagnostic(help("make the joints of the rollers `continuous`"))]
    RollersDoNotTurn {
        /// The number of rollers per wheel.
        rollers: usize,
        /// The wheels' joints.
        wheels: Vec<String>,
    },
    /// The chassis reaches the floor on which the wheels stand, or below it.
    #[error(
        "its collision geometry {}, at x = {:.3} m, y = {:.3} m",
        above_floor(*deep_mm), at_m[0], at_m[1]
    )]
    #[diagnostic(help(
        "raise the collision geometry, or lower the wheels: where it touches the floor it carries the robot in their place"
    ))]
    ChassisBelowFloor {
        /// Depth below the floor, in millimetres; negative for a clearance smaller than the first
        /// bump or a tread's deflection.
        deep_mm: f64,
        /// The position in the body frame, in metres.
        at_m: [f64; 2],
    },
    /// Two wheels on tyres, and nothing else that the robot stands on.
    #[error(
        "it stands on two wheels alone{}: nothing of the file reaches the floor as a caster does",
        lean_deg.map_or_else(String::new, |deg| format!(", or leans on its chassis by {deg:.1} deg"))
    )]
    #[diagnostic(help(
        "add the collision geometry of its caster: a ball that is fixed to the chassis and reaches the floor, or a wheel on joints that swivel freely; if its meshes show it, let them be found"
    ))]
    NoCaster {
        /// By how much it leans where its chassis reaches the floor, in degrees; `None` if it does
        /// not.
        lean_deg: Option<f64>,
    },
    /// A roller's axis is parallel to its hub's.
    #[error("gamma = 90 deg: the roller turns about the hub axis, and the wheel cannot drive")]
    #[diagnostic(help(
        "turn the roller's axis away from the hub's: gamma is 45 deg for mecanum wheels and 0 for omni wheels"
    ))]
    GammaRightAngle,
    /// A hub axis that is not parallel to the ground.
    #[error("the hub axis leans {lean_deg:.1} deg out of the ground plane")]
    #[diagnostic(help(
        "make the axis horizontal in the frame of the root link, whose z must point up"
    ))]
    HubNotLevel {
        /// Its angle from the ground, in degrees.
        lean_deg: f64,
    },
    /// A roller has no collision geometry.
    #[error("the roller has no collision geometry, so that its size is not known")]
    #[diagnostic(help(
        "give the roller a `<collision>`: a stack of spheres, a cylinder or a capsule along its axis"
    ))]
    RollerWithoutShape,
    /// A roller's collision geometry is not round about its axis.
    #[error("the roller's collision geometry is not round about its axis")]
    #[diagnostic(help("use spheres on the axis, or a cylinder, capsule or square box along it"))]
    RollerNotRound,
    /// A mesh cannot be read.
    #[error("its mesh `{mesh}` cannot be read: {reason}")]
    #[diagnostic(help(
        "give the mesh as STL, OBJ or COLLADA at its place, or a shape instead of it"
    ))]
    MeshUnreadable {
        /// The mesh's file.
        mesh: String,
        /// The reason.
        reason: String,
    },
    /// The folder of a ROS package is unknown.
    #[error("its mesh `{mesh}` lies in the package `{package}`, whose folder is not known")]
    #[diagnostic(help("say where the package lies"))]
    PackageUnknown {
        /// The package.
        package: String,
        /// The mesh as named in the file.
        mesh: String,
    },
    /// An element that names a missing joint.
    #[error("there is no joint `{joint}`")]
    #[diagnostic(help("{}", near.as_ref().map_or_else(|| if others.is_empty() { "the file has no joint that can be named here".to_owned() } else { format!("the file has the joints {}", listed(others)) }, |near| format!("did you mean `{near}`?"))))]
    UnknownJoint {
        /// The joint.
        joint: String,
        /// The joint of the file with the most similar name.
        near: Option<String>,
        /// The joints that can be named.
        others: Vec<String>,
    },
    /// A joint named as a wheel is missing.
    #[error(
        "there is no joint `{joint}`{}{}",
        if likely.is_empty() { String::new() } else { format!("; wheels could be {}", listed(likely)) },
        if likely.is_empty() { looked_at(looked) } else { String::new() }
    )]
    #[diagnostic(help("{}", if likely.is_empty() { "name joints whose wheels turn on level axes and stand on the floor" } else { "name joints of the file" }))]
    NoSuchJoint {
        /// The joint.
        joint: String,
        /// The possible wheel joints.
        likely: Vec<String>,
        /// The other joints, with the reasons why they are no wheels.
        looked: Vec<CandidateJoint>,
    },
    /// A joint named as a wheel cannot be one.
    #[error("it cannot be taken for a wheel: {reason}")]
    #[diagnostic(help("name another joint, or give this one a level axis"))]
    NotAWheel {
        /// The reason.
        reason: String,
    },
    /// A joint to which rollers should be added already has some.
    #[error("it has rollers in the file already")]
    #[diagnostic(help("leave this joint out of the wheels that are given rollers"))]
    HasRollers,
    /// The radius of a wheel is unknown: one that gets rollers, or one whose rollers have no
    /// geometry.
    #[error("the wheel's geometry does not show its radius{}", reason.as_ref().map_or(String::new(), |r| format!(": {r}")))]
    #[diagnostic(help("{}", clues.help()))]
    WheelSizeUnknown {
        /// Why its geometry does not show it.
        reason: Option<String>,
        /// Other evidence for a radius.
        clues: Box<Clues>,
        /// The package of its geometry, if that package's folder is unknown.
        package: Option<String>,
    },
    /// A wheel's joint states no axis, and its cylinder lies across the one that is meant then.
    #[error(
        "its joint states no `<axis>`, so that it turns about x, across which its cylinder lies"
    )]
    #[diagnostic(help("give the joint an `<axis>` along the cylinder"))]
    NoAxis,
    /// The usual X is requested, but the wheels are not arranged that way.
    #[error(
        "the usual X arrangement has parallel hub axes and wheels off both middle lines: here {what}"
    )]
    #[diagnostic(help("give gamma for all wheels, or for each wheel, instead"))]
    NotInX {
        /// The deviation.
        what: &'static str,
    },
    /// A roller differs from the others of its wheel.
    #[error("{quantity} is {this} at this roller and {others} on average over its wheel")]
    #[diagnostic(help("make the rollers of a wheel alike"))]
    RollersDiffer {
        /// The quantity.
        quantity: &'static str,
        /// Its value for this roller.
        this: String,
        /// Its mean over the wheel.
        others: String,
    },
    /// Rollers cannot be made with the file's settings.
    #[error("the rollers cannot be made so: {reason}")]
    #[diagnostic(help("write a value within its range, or leave it out for the ideal barrel"))]
    RollersNotMade {
        /// The reason.
        reason: String,
    },
    /// A wheel has angles at which no roller touches the ground.
    #[error(
        "the rollers leave gaps of up to {widest_gap_deg:.2} deg, {share_percent:.1} % of the turn, over which the wheel \
         falls between them{}",
        if *missing > 0 { format!(": by their places {missing} of {of} are missing in the file") } else { String::new() }
    )]
    #[diagnostic(help("{}", if *missing > 0 { ROLLERS_APART } else { LONGER_ROLLERS }))]
    RollersHaveGaps {
        /// The widest gap, in degrees of the wheel's turn.
        widest_gap_deg: f64,
        /// The share of a turn without a roller, in percent.
        share_percent: f64,
        /// Number of rollers missing from an even ring, judged by the positions of the others.
        missing: usize,
        /// Number of rollers of the full ring.
        of: usize,
        /// Whether the wheel could roll over the gaps with its file's shapes.
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
    #[diagnostic(help("let all wheels reach the same height in the frame of the root link"))]
    UnevenWheels {
        /// Height of this wheel's lowest point above the lowest wheel's, in the frame of the root
        /// link, in millimetres.
        apart_mm: f64,
        /// Lean of the robot, in degrees.
        tilt_deg: f64,
        /// Height of this wheel above the floor, in millimetres; 0 if it stands on it.
        gap_mm: f64,
        /// The largest accepted lean, in degrees.
        most_deg: f64,
    },
    /// A wheel so large that the file must be in millimetres.
    #[error("the wheel has a radius of {radius_m:.1} m")]
    #[diagnostic(help("URDF is in metres: scale the file by 0.001 if it is in millimetres"))]
    LooksLikeMillimetres {
        /// Its radius, in metres.
        radius_m: f64,
    },
}
