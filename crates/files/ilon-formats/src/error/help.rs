//! Remedies for each fault: as text, and as options of reading.

use super::fault::{Fault, Proposed};
use super::named::MissingFile;
use super::remedy::Remedy;
use crate::options::{Handedness, LoadOptions, WheelOptions};
use crate::xml;

/// Help without a CAD program.
const BOX: &str = "for a solid box of mass m, ixx = m (y^2 + z^2) / 12";

/// Start of the reason if a xacro file needs an unset environment variable.
pub(crate) const NOT_SET: &str = "the environment variable `";

/// Whether an attribute sets a shape's size to zero, as for links that are only frames.
pub(crate) fn is_zero_size(key: &str, value: &str) -> bool {
    ["size", "radius", "length"].contains(&key)
        && xml::numbers(value).is_some_and(|n| n.iter().all(|x| *x >= 0.0) && n.contains(&0.0))
}

/// Whether an argument only sets names.
fn is_of_names(argument: &str) -> bool {
    let lower = argument.to_lowercase();
    lower.ends_with("name") || lower.ends_with("namespace") || lower.ends_with("prefix")
}

impl Fault {
    /// A file that cannot be read, with the reason.
    pub(crate) fn unreadable(reason: impl ToString) -> Self {
        let reason = reason.to_string();
        Self::Unreadable { reason }
    }

    /// An attribute that an element lacks.
    pub(crate) fn missing_attribute(name: &str) -> Self {
        let attribute = name.to_owned();
        Self::MissingAttribute { attribute }
    }

    /// A missing joint, with the one of `others` that was probably meant.
    pub(crate) fn unknown_joint<'a>(joint: &str, others: impl Iterator<Item = &'a str>) -> Self {
        /// Smallest Jaro-Winkler similarity of two names of which one was meant for the other.
        const ALIKE: f64 = 0.8;
        let alike = others.map(|other| (strsim::jaro_winkler(joint, other), other));
        let best = alike.max_by(|a, b| a.0.total_cmp(&b.0));
        let near = best.filter(|(likeness, _)| *likeness > ALIKE);
        Self::UnknownJoint {
            joint: joint.to_owned(),
            near: near.map(|(_, name)| name.to_owned()),
        }
    }

    /// The key of a description that is at fault, if one is.
    pub(crate) fn key(&self) -> Option<&str> {
        match self {
            Self::OutOfRange { key, .. }
            | Self::NoSuchWheel { key, .. }
            | Self::RollersTooSlender { key, .. } => Some(key),
            Self::RollersNotMade { .. } => Some("rollers"),
            _ => None,
        }
    }

    /// Returns how to repair it in the file; for the options of reading see [`Self::remedies`].
    pub(super) fn help(&self) -> String {
        let fixed = match self {
            Self::Toml { help, .. } if !help.is_empty() => return help.clone(),
            Self::OutOfRange { key, range, .. } => return format!("make `{key}` {range}"),
            Self::TooManyWheels { .. } => {
                "write type=\"fixed\" for joints that do not turn, or read a file of one robot"
            }
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
            Self::MissingElement { child: "inertia" } => {
                return format!(
                    "add `<inertia ixx=\"...\" ixy=\"0\" ixz=\"0\" iyy=\"...\" iyz=\"0\" izz=\"...\"/>`; {BOX}"
                );
            }
            Self::MissingElement { child } => return format!("add `<{child}>` to the element"),
            Self::NotNumbers { count: 1, .. } => "write a number",
            Self::NotNumbers { count, .. } => {
                return format!("write {count} numbers, separated by spaces");
            }
            Self::Unreadable { reason } if reason.contains("UTF-8") => "save it as UTF-8",
            Self::Unreadable { .. } => "give the path of a file that exists and may be read",
            Self::Toml { .. } => {
                "every key is described in docs/format-robot.md, of robots on tyres in docs/format-robot-on-tyres.md; whole descriptions are in assets/robots"
            }
            Self::NotADescription { .. } => {
                "name the description from which the robot is generated, or leave these keys out"
            }
            Self::Xml { reason } if reason.contains("XML declaration") => {
                "an XML declaration, `<?xml ...?>`, stands at the very beginning of a file or nowhere: put it before all else, comments and empty \
                 lines too, or leave it out"
            }
            Self::Xml { reason } if reason.contains("DTD") => {
                "leave out `<!DOCTYPE ...>`: it can name other files, and none of a robot's formats needs it"
            }
            Self::Xml { reason } if reason.contains("not a robot file") => {
                "name a URDF, xacro, SDF or MJCF file, or a description in TOML"
            }
            Self::Xml { .. } => "close every element and quote every attribute",
            Self::NotUrdf { .. } => {
                "give a URDF, xacro, SDF or MJCF file, or a description in TOML"
            }
            Self::Xacro { reason, .. } if reason.contains(NOT_SET) => {
                "set the environment variable before the file is read, as a shell does by `NAME=VALUE` before a command"
            }
            Self::Xacro { .. } => {
                "repair the place that is named; a file that you trust can be expanded by the xacro of ROS, which runs what stands in it"
            }
            Self::MissingFiles { files } => {
                return if files.iter().any(|file| file.package.is_some()) {
                    "say where the packages lie, or go without them".to_owned()
                } else {
                    "put the files there, or go without them".to_owned()
                };
            }
            Self::MissingArgument {
                name,
                any_does: true,
            } => {
                return format!(
                    "give `{name}` a value, or a default where it is declared; whatever it is, the robot is the same"
                );
            }
            Self::MissingArgument { name, .. } => {
                return format!("give `{name}` a value, or a default where it is declared");
            }
            Self::MacrosOnly { .. } => "give the file that calls them",
            Self::OldXacro { .. } => {
                "write `<xacro:include>`, `<xacro:property>`, `<xacro:macro>` and `<xacro:...>` for each call of a macro"
            }
            Self::Format { reason } if reason.contains("<mujocoinclude>") => {
                "give the file that includes it"
            }
            Self::Format { .. } => "change the file, or convert it to URDF",
            Self::TooLarge { .. } => "give a smaller file",
            Self::Urdf { .. } => {
                "compare with the URDF specification, http://wiki.ros.org/urdf/XML"
            }
            Self::DuplicateName { .. } => "give each link and each joint a name of its own",
            Self::NotFinite { .. } => {
                "write a finite number; a limit that does not exist is left out"
            }
            Self::InertiaNotPositive { .. }
            | Self::InertiaImpossible { .. }
            | Self::InertiaTooLarge { .. }
            | Self::InertiaTooSmall { .. }
            | Self::InertiaExchanged
            | Self::InertiaThinAboutAxle { .. } => {
                return format!("take the inertia from a CAD program, or {BOX}");
            }
            Self::UnknownGeometry => "give the collision one of these geometries",
            Self::UnknownJointType { .. } => {
                "use `continuous` for wheels and rollers and `fixed` for what does not move"
            }
            Self::UnknownLink { .. } => "add the link, or correct its name here",
            Self::ZeroAxis => "give the axis a direction, such as `<axis xyz=\"0 1 0\"/>`",
            Self::TwoParents { .. } => "remove one of the joints: a URDF is a tree",
            Self::Loop => "remove one joint of the loop: a URDF is a tree with one root",
            Self::SeveralRoots { .. } => {
                "join them by fixed joints, so that one root is left, or remove what does not belong"
            }
            Self::JointRole { .. } => {
                "a joint between bodies may be `free`, `sprung` with a stiffness, `driven` by a servo, or `held`"
            }
            Self::NoMass => "add an `<inertial>` with mass and inertia",
            Self::TooFewWheels { on_tyres: true, .. } => {
                "a wheel is a continuous joint on a level axis whose shape stands on the floor; or name the joints of all wheels"
            }
            Self::TooFewWheels { .. } => {
                "a wheel is a continuous joint on a level axis, with three or more continuous roller joints below it on a \
                 ring; or name the joints of wheels that are modelled without rollers; a robot whose file has no wheels is described in TOML, see docs/format-robot.md"
            }
            Self::NoRollers {
                rollers: Proposed::Contradiction,
                why: Some(why),
                ..
            } => {
                return format!(
                    "{why}; say which rollers they carry and on which joints, and they are put in"
                );
            }
            Self::NoRollers {
                rollers: Proposed::Contradiction,
                why: None,
                ..
            } => {
                "they are called mecanum wheels, whose hubs are parallel, and theirs are not: turn the joints so that they are, \
                 for gamma is the angle of the rollers and not of the hubs; or say which rollers they carry, and they are put in"
            }
            Self::NoRollers {
                rollers: Proposed::NothingSaid,
                why: None,
                ..
            } => {
                "nothing in the file says that these are Swedish wheels; if they are, say which rollers they carry, and they are put in; else let them roll on tyres"
            }
            Self::NoRollers {
                rollers: Proposed::NothingSaid,
                why: Some(hint),
                ..
            } => {
                return format!(
                    "nothing in the file says that these are Swedish wheels: {hint}; if they are, say which rollers they carry, and they are put in; else let them roll on tyres"
                );
            }
            Self::NoRollers { why: Some(why), .. } => {
                return format!("say which rollers they carry, and they are put in; {why}");
            }
            Self::NoRollers { .. } => "say which rollers they carry, and they are put in",
            Self::Steered { .. } => {
                "let them roll on tyres; or if these stand for Swedish wheels, name them: their upright joints are \
                 held, and rollers are put in"
            }
            Self::HubDoesNotTurn { .. } => "make the joint `continuous`, with the hub's axis",
            Self::RollersDoNotTurn { .. } => "make the joints of the rollers `continuous`",
            Self::NoCaster { .. } => {
                "add the collision geometry of its caster: a ball that is fixed to the chassis and reaches the floor, or a wheel on joints that swivel freely; \
                 if its meshes show it, let them be found"
            }
            Self::ChassisBelowFloor { .. } => {
                "raise the collision geometry, or lower the wheels: where it touches the floor it carries the robot in their place"
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
                "give the mesh as STL, OBJ or COLLADA at its place, or a shape instead of it"
            }
            Self::PackageUnknown { .. } => "say where the package lies",
            Self::NoSuchJoint { likely, .. } if likely.is_empty() => {
                "name joints whose wheels turn on level axes and stand on the floor"
            }
            Self::UnknownJoint {
                near: Some(near), ..
            } => return format!("did you mean `{near}`?"),
            Self::NoSuchJoint { .. } | Self::UnknownJoint { .. } => "name joints of the file",
            Self::NoSuchWheel { .. } => "name a wheel that the description has",
            Self::NotAWheel { .. } => "name another joint, or give this one a level axis",
            Self::HasRollers => "leave this joint out of the wheels that are given rollers",
            Self::WheelSizeUnknown { clues, .. } => return clues.help(),
            Self::NoAxis => "give the joint an `<axis>` along the cylinder",
            Self::NotInX { .. } => "give gamma for all wheels, or for each wheel, instead",
            Self::RollersDiffer { .. } => "make the rollers of a wheel alike",
            Self::RollersNotMade { .. } => {
                "write a value within its range, or leave it out for the ideal barrel"
            }
            Self::RollersHaveGaps { missing: 1.., .. } => {
                "model each roller as a link on a turning joint of its own: what is part of the hub's mesh does not turn"
            }
            Self::RollersHaveGaps { .. } => {
                "make the rollers longer: neighbours hand over at L = 2 a tan(pi/n) / cos(gamma)"
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

    /// Returns options with a stand-in for an unknown that only the user knows, only for reading
    /// more of the file. `None` if there is no stand-in.
    pub(crate) fn stood_in(&self, options: &LoadOptions) -> Option<LoadOptions> {
        /// Rollers of a stand-in wheel.
        const ROLLERS: usize = 12;
        let mut stood_in = options.clone();
        match self {
            Self::NoRollers { wheels, .. } | Self::Steered { wheels, .. } => {
                // On parallel hubs only inclined rollers allow sideways motion.
                let parallel = matches!(
                    self.remedies()[..],
                    [Remedy::WhichRollers { parallel: true, .. }, ..]
                );
                let gamma = match parallel {
                    true => Handedness::XDeg(45.0),
                    false => Handedness::AllDeg(0.0),
                };
                let rollers = WheelOptions::new(ROLLERS, gamma);
                stood_in.wheels = Some(rollers.on(wheels.clone()));
            }
            Self::WheelSizeUnknown { clues, .. } => {
                stood_in.wheel_radius_m = Some(clues.stand_in_m());
            }
            Self::MissingArgument { name, .. } => {
                stood_in.arguments.insert(name.clone(), "1".to_owned());
            }
            _ => return None,
        }
        Some(stood_in)
    }

    /// Whether it may be caused only by a wrong size of the wheels.
    pub(crate) fn is_of_sizes(&self) -> bool {
        matches!(
            self,
            Self::ChassisBelowFloor { .. }
                | Self::UnevenWheels { .. }
                | Self::RollersHaveGaps { .. }
                | Self::RollersTooSlender { .. }
                | Self::RollersDiffer { .. }
                | Self::InertiaTooLarge { .. }
                | Self::LooksLikeMillimetres { .. }
        )
    }

    /// Returns the options of reading that repair it, the best first.
    pub(super) fn remedies(&self) -> Vec<Remedy> {
        match self {
            Self::MissingElement {
                child: "inertia" | "mass",
            }
            | Self::MissingAttribute { .. }
            | Self::DuplicateName { .. }
            | Self::InertiaNotPositive { .. }
            | Self::InertiaImpossible { .. }
            | Self::InertiaTooLarge { .. }
            | Self::InertiaTooSmall { .. }
            | Self::InertiaExchanged
            | Self::InertiaThinAboutAxle { .. }
            | Self::NoMass
            | Self::TwoParents { .. }
            | Self::Loop
            | Self::NoAxis
            | Self::HubDoesNotTurn { .. }
            | Self::RollersDoNotTurn { .. } => vec![Remedy::Repair],
            Self::Xacro {
                before_2014: true, ..
            }
            | Self::OldXacro { .. } => vec![Remedy::Repair],
            // The robot's name does not change the robot.
            Self::MissingArgument { name, .. } if is_of_names(name) => vec![Remedy::Argument {
                name: name.clone(),
                value: Some("robot".to_owned()),
            }],
            Self::OutOfRange { key, value, .. }
                if (key == "value" && value == "0") || is_zero_size(key, value) =>
            {
                vec![Remedy::Repair]
            }
            // Longer rollers do not replace a missing one.
            Self::RollersHaveGaps { missing: 1.., .. } => Vec::new(),
            Self::RollersHaveGaps { rolls: false, .. } => vec![Remedy::Repair],
            Self::RollersHaveGaps { .. } => vec![Remedy::Repair, Remedy::AsModelled],
            Self::MissingFiles { files } => {
                let mut remedies: Vec<Remedy> = Vec::new();
                for file in files {
                    let remedy = file.package.clone().map(|name| Remedy::Package {
                        name,
                        folder: file.folder.clone(),
                    });
                    remedies.extend(remedy.filter(|remedy| !remedies.contains(remedy)));
                }
                // Missing roller files must not be replaced by guesses.
                let is_of_rollers = |file: &MissingFile| file.what.contains("roller");
                if !files.iter().any(is_of_rollers) {
                    remedies.push(Remedy::LeaveOutMissing);
                }
                remedies
            }
            Self::ChassisBelowFloor { .. } => vec![Remedy::Repair],
            Self::UnknownLink { .. } | Self::SeveralRoots { .. } => vec![Remedy::LeaveOutMissing],
            Self::Format { reason } if reason.ends_with("which is no link") => {
                vec![Remedy::LeaveOutMissing]
            }
            Self::MissingArgument { name, .. } => vec![Remedy::Argument {
                name: name.clone(),
                value: None,
            }],
            Self::NoRollers {
                rollers: Proposed::Rollers(rollers),
                ..
            }
            | Self::Steered {
                rollers: Proposed::Rollers(rollers),
                ..
            } => vec![Remedy::Rollers(rollers.clone())],
            Self::NoRollers {
                wheels,
                rollers,
                why,
                ..
            } => vec![Remedy::WhichRollers {
                wheels: wheels.clone(),
                parallel: *rollers == Proposed::NothingSaid || why.is_some(),
            }],
            Self::Steered {
                wheels, rollers, ..
            } => vec![Remedy::WhichRollers {
                wheels: wheels.clone(),
                parallel: *rollers == Proposed::NothingSaid,
            }],
            Self::PackageUnknown { package, .. } => vec![Remedy::Package {
                name: package.clone(),
                folder: None,
            }],
            Self::WheelSizeUnknown { clues, package, .. } => {
                let package = package
                    .clone()
                    .map(|name| Remedy::Package { name, folder: None });
                let radius = Remedy::WheelRadius {
                    guess_m: clues.proposed_m(),
                };
                package.into_iter().chain([radius]).collect()
            }
            _ => Vec::new(),
        }
    }
}
