//! What can be wrong with a robot's file: where, what, and how to mend it.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// Where in a text a fault sits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The bytes of the text that are at fault.
    pub bytes: Range<usize>,
}

impl Place {
    /// The place of a range of bytes in `text`.
    pub fn of_bytes(text: &str, bytes: Range<usize>) -> Self {
        let start = (0..=bytes.start.min(text.len()))
            .rev()
            .find(|&i| text.is_char_boundary(i))
            .unwrap_or(0);
        let before = &text[..start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Self {
            line: before.bytes().filter(|&b| b == b'\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            bytes: start..bytes.end.clamp(start, text.len()),
        }
    }
}

/// A robot's file that cannot be used: the fault, where it is, and how to mend it.
///
/// Its `Display` is one line, ``robot.urdf:12: joint `arm`: ...``; [`RobotError::help`] says how to mend it, and the
/// other accessors serve printers that show the line itself.
#[derive(Clone, Debug)]
pub struct RobotError(Box<Inner>);

#[derive(Clone, Debug)]
struct Inner {
    fault: Fault,
    file: String,
    text: Option<Arc<str>>,
    place: Option<Place>,
    element: Option<String>,
}

impl RobotError {
    /// A fault in `file`, not yet placed.
    pub(crate) fn new(file: &str, fault: Fault) -> Self {
        Self(Box::new(Inner {
            fault,
            file: file.to_owned(),
            text: None,
            place: None,
            element: None,
        }))
    }

    /// The same, at a range of bytes of the file's text.
    pub(crate) fn at(mut self, text: &str, bytes: Range<usize>) -> Self {
        self.0.place = Some(Place::of_bytes(text, bytes));
        self.0.text = Some(Arc::from(text));
        self
    }

    /// The same, about an element such as ``joint `arm` ``.
    pub(crate) fn about(mut self, element: impl Into<String>) -> Self {
        self.0.element = Some(element.into());
        self
    }

    /// The same with another fault.
    pub(crate) fn with_fault(mut self, fault: Fault) -> Self {
        self.0.fault = fault;
        self
    }

    /// What is wrong.
    pub fn fault(&self) -> &Fault {
        &self.0.fault
    }

    /// The file, as it was named when it was asked for.
    pub fn file(&self) -> &str {
        &self.0.file
    }

    /// The whole text of the file, where the fault has a place in it.
    pub fn text(&self) -> Option<&str> {
        self.0.text.as_deref()
    }

    /// Line, column and bytes, where they are known.
    pub fn place(&self) -> Option<&Place> {
        self.0.place.as_ref()
    }

    /// The line, from 1, where it is known.
    pub fn line(&self) -> Option<usize> {
        self.0.place.as_ref().map(|p| p.line)
    }

    /// The element at fault, such as ``joint `arm` ``, where there is one.
    pub fn element(&self) -> Option<&str> {
        self.0.element.as_deref()
    }

    /// How to mend it.
    pub fn help(&self) -> String {
        self.0.fault.help()
    }
}

impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.file)?;
        if let Some(place) = &self.0.place {
            write!(f, ":{}", place.line)?;
        }
        if let Some(element) = &self.0.element {
            write!(f, ": {element}")?;
        }
        write!(f, ": {}", self.0.fault)
    }
}

impl std::error::Error for RobotError {}

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
    #[error("not well-formed XML: {reason}")]
    Xml {
        /// What the parser said.
        reason: String,
    },
    /// The root element is not `<robot>`.
    #[error("not a URDF: its root element is `<{root_tag}>`, not `<robot>`")]
    NotUrdf {
        /// The tag of the root element.
        root_tag: String,
    },
    /// The file is the xacro source of a URDF.
    #[error(
        "an unexpanded xacro file: it holds {what}{}",
        tried.as_ref().map_or_else(String::new, |why| format!("; it could not be expanded here: {why}"))
    )]
    Unexpanded {
        /// What gave it away.
        what: String,
        /// Why it could not be expanded, where that was tried.
        tried: Option<String>,
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
    /// An element that may stand once stands twice.
    #[error("`<{child}>` stands here a second time")]
    Repeated {
        /// Its tag.
        child: String,
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
    #[error("`{attribute}=\"{value}\"` does not hold {count} number(s)")]
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
    /// The robot has fewer than three wheels.
    #[error(
        "{} wheel(s) with passive rollers{}, but moving freely in the plane takes three",
        wheels.len(),
        if wheels.is_empty() { String::new() } else { format!(": {}", listed(wheels)) }
    )]
    TooFewWheels {
        /// The joints of the wheels that were found.
        wheels: Vec<String>,
    },
    /// The robot has wheels, but they carry no rollers.
    #[error("{} wheels without rollers: {}", wheels.len(), listed(wheels))]
    NoRollers {
        /// Their joints.
        wheels: Vec<String>,
    },
    /// The robot has steered wheels.
    #[error("{} steered wheels, on upright joints: {}. These are not Swedish wheels", wheels.len(), listed(wheels))]
    Steered {
        /// Their joints.
        wheels: Vec<String>,
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
    /// The chassis reaches below the floor on which the wheels stand.
    #[error(
        "its collision geometry reaches {deep_mm:.1} mm below the floor on which the wheels stand"
    )]
    ChassisBelowFloor {
        /// How far, in millimetres.
        deep_mm: f64,
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
    /// A joint that should carry rollers is not there, or does not turn.
    #[error("there is no turning joint `{joint}` to put rollers on")]
    NoSuchWheel {
        /// The joint.
        joint: String,
        /// The turning joints that are there.
        turning: Vec<String>,
    },
    /// A joint that should be given rollers has some.
    #[error("it has rollers in the file already")]
    HasRollers,
    /// The radius of a wheel that is given rollers is not known.
    #[error("the wheel's collision geometry does not show its radius")]
    WheelSizeUnknown,
    /// The usual X is asked for, but the wheels do not stand in it.
    #[error(
        "the usual X arrangement has hub axes along y and wheels off both middle lines: here {what}"
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
    /// A wheel has angles at which no roller touches the ground.
    #[error(
        "the rollers leave gaps of up to {widest_gap_deg:.2} deg, {share_percent:.1} % of the turn, over which the wheel \
         falls between them"
    )]
    RollersHaveGaps {
        /// The widest gap, in degrees of the wheel's turn.
        widest_gap_deg: f64,
        /// The share of a turn without a roller, in per cent.
        share_percent: f64,
    },
    /// Wheels do not stand on one floor.
    #[error("it stands {apart_mm:.2} mm above the floor on which `{lower_wheel}` stands")]
    UnevenWheels {
        /// The joint of the lowest wheel.
        lower_wheel: String,
        /// How much higher this one stands, in millimetres.
        apart_mm: f64,
    },
    /// A wheel is so large that the file must be in millimetres.
    #[error("the wheel has a radius of {radius_m:.1} m")]
    LooksLikeMillimetres {
        /// Its radius, in metres.
        radius_m: f64,
    },
}

fn listed(names: &[String]) -> String {
    const SHOWN: usize = 8;
    let mut text = names
        .iter()
        .take(SHOWN)
        .map(|n| format!("`{n}`"))
        .collect::<Vec<_>>()
        .join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(" and {} more", names.len() - SHOWN));
    }
    text
}

impl Fault {
    fn help(&self) -> String {
        let fixed = match self {
            Self::OutOfRange { key, range, .. } => return format!("make `{key}` {range}"),
            Self::RollersTooSlender {
                least_radius_mm, ..
            } => {
                return format!(
                    "make the rollers thicker than {least_radius_mm:.2} mm, or use more of them"
                );
            }
            Self::MissingAttribute { attribute } => {
                return format!("add `{attribute}=\"...\"` to the element");
            }
            Self::MissingElement { child } => {
                return match *child {
                    "inertia" => "add `<inertia ixx=\"...\" ixy=\"0\" ixz=\"0\" iyy=\"...\" iyz=\"0\" \
                                  izz=\"...\"/>`; for a solid box of mass m, ixx = m (y^2 + z^2) / 12. Or let it be \
                                  mended: `--mend`, or `mend = true` in a scenario's `[robot]`, takes that of a ball"
                        .to_owned(),
                    child => format!("add `<{child}>` to the element"),
                };
            }
            Self::Repeated { child } => {
                return format!(
                    "keep one `<{child}>` and remove the other; `--mend`, or `mend = true` in a scenario's `[robot]`, keeps \
                     the first"
                );
            }
            Self::NotNumbers { count, .. } => {
                return format!("write {count} number(s), separated by spaces");
            }
            Self::Unreadable { .. } => "give the path of a file that exists and may be read",
            Self::Toml { .. } => {
                "compare with the robots in assets/robots, or see the documentation of `Spec`"
            }
            Self::Xml { .. } => "close every element and quote every attribute",
            Self::NotUrdf { .. } => "give a URDF file; SDF and MJCF must be converted to it first",
            Self::Unexpanded { .. } => {
                "expand it first: `xacro robot.urdf.xacro > robot.urdf`, with the xacro of ROS or of `pip install xacro`"
            }
            Self::TooLarge { .. } => "give a smaller file",
            Self::Urdf { .. } => {
                "compare with the URDF specification, http://wiki.ros.org/urdf/XML"
            }
            Self::DuplicateName { .. } => "give each link and each joint a name of its own",
            Self::NotFinite { .. } => {
                "write a finite number; a limit that does not exist is left out"
            }
            Self::InertiaNotPositive { .. } | Self::InertiaImpossible { .. } => {
                "take the inertia from a CAD program, or from the formula of a solid box: ixx = m (y^2 + z^2) / 12. Or let it \
                 be mended: `--mend`, or `mend = true` in a scenario's `[robot]`, takes that of a ball of the same mass"
            }
            Self::UnknownGeometry => "give the collision one of these geometries",
            Self::UnknownJointType { .. } => {
                "use `continuous` for wheels and rollers and `fixed` for what does not move"
            }
            Self::UnknownLink { .. } => "add the link, or mend its name here",
            Self::ZeroAxis => "give the axis a direction, such as `<axis xyz=\"0 1 0\"/>`",
            Self::TwoParents { .. } => "remove one of the joints: a URDF is a tree",
            Self::Loop => "remove one joint of the loop: a URDF is a tree with one root",
            Self::SeveralRoots { .. } => {
                "join them by fixed joints, so that one root is left, or remove what does not belong"
            }
            Self::NoMass => "add an `<inertial>` with mass and inertia",
            Self::TooFewWheels { .. } => {
                "a wheel is a continuous joint with three or more continuous roller joints below it, on a ring"
            }
            Self::NoRollers { .. } => {
                "say which rollers they carry, and they are put in: `--rollers 12 --gamma-x-deg 45`, or `[robot.wheels]` in \
                 a scenario"
            }
            Self::Steered { .. } => {
                "steered wheels need another tool; if these stand for Swedish wheels, name their joints with `--wheels`, or in \
                 a scenario's `[robot.wheels]`, to hold the upright joints and put rollers in"
            }
            Self::HubDoesNotTurn { .. } => "make the joint `continuous`, with the hub's axis",
            Self::ChassisBelowFloor { .. } => {
                "raise the collision geometry, or lower the wheels: the wheels must reach the floor first"
            }
            Self::GammaRightAngle => {
                "turn the roller's axis away from the hub's: gamma is 45 deg for mecanum wheels and 0 for omni wheels"
            }
            Self::HubNotLevel { .. } => {
                "make the axis horizontal in the frame of the root link, whose z must point up"
            }
            Self::RollerWithoutShape => {
                "give the roller a `<collision>`: a stack of spheres, a cylinder or a capsule along its axis"
            }
            Self::RollerNotRound => {
                "use spheres on the axis, or a cylinder, capsule or square box along it"
            }
            Self::MeshUnreadable { .. } => {
                "give the mesh as STL, OBJ or COLLADA, or replace it by spheres on the roller's axis"
            }
            Self::PackageUnknown { package, .. } => {
                return format!("say where it is: `--package {package}=FOLDER`");
            }
            Self::NoSuchWheel { turning, .. } => {
                return format!("name one of the turning joints: {}", listed(turning));
            }
            Self::HasRollers => "leave this joint out of the wheels that are given rollers",
            Self::WheelSizeUnknown => {
                "say it: `--wheel-radius-m`, or `radius_m` in a scenario's `[robot.wheels]`"
            }
            Self::NotInX { .. } => "give gamma for each wheel instead: `gamma.each_deg = [...]`",
            Self::RollersDiffer { .. } => "make the rollers of a wheel alike",
            Self::RollersHaveGaps { .. } => {
                "make the rollers longer: neighbours hand over at L = 2 a tan(pi/n) / cos(gamma). Or let it be mended: \
                 `--mend`, or `mend = true` in a scenario's `[robot]`, makes them so long; or take the gaps as they are: \
                 `--as-modelled`, or `rollers = \"as_modelled\"` there"
            }
            Self::UnevenWheels { .. } => {
                "let all wheels reach the same height in the frame of the root link"
            }
            Self::LooksLikeMillimetres { .. } => {
                "URDF is in metres: scale the file by 0.001 if it is in millimetres"
            }
        };
        fixed.to_owned()
    }
}
