//! Remedies for faults: texts that depend on what is at fault, and options of reading.

use super::fault::{Fault, Proposed};
use super::named::MissingFile;
use super::remedy::Remedy;
use crate::options::{Handedness, LoadOptions, WheelOptions};
use crate::xml;

/// Help without a CAD program.
pub(super) const BOX: &str = "for a solid box of mass m, ixx = m (y^2 + z^2) / 12";
/// Help with a description in TOML.
pub(super) const DESCRIPTIONS: &str = "every key is described in docs/format-robot.md, of robots on tyres in docs/format-robot-on-tyres.md; whole descriptions are in assets/robots";
/// What counts as a wheel with rollers.
pub(super) const WHEELS: &str = "a wheel is a continuous joint on a level axis, with three or more continuous roller joints below it on a \
     ring; or name the joints of wheels that are modelled without rollers; a robot whose file has no wheels is described in TOML, see docs/format-robot.md";
/// What counts as a wheel on tyres.
pub(super) const WHEELS_ON_TYRES: &str = "a wheel is a continuous joint on a level axis whose shape stands on the floor; or name the joints of all wheels";
/// Help with rollers that are not all there.
pub(super) const ROLLERS_APART: &str = "model each roller as a link on a turning joint of its own: what is part of the hub's mesh does not turn";
/// Help with rollers that leave gaps.
pub(super) const LONGER_ROLLERS: &str =
    "make the rollers longer: neighbours hand over at L = 2 a tan(pi/n) / cos(gamma)";

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

/// Help with an element that is missing.
pub(super) fn of_element(child: &str) -> String {
    match child {
        "inertia" => format!(
            "add `<inertia ixx=\"...\" ixy=\"0\" ixz=\"0\" iyy=\"...\" iyz=\"0\" izz=\"...\"/>`; {BOX}"
        ),
        child => format!("add `<{child}>` to the element"),
    }
}

/// Help with a file that cannot be read.
pub(super) fn of_reading(reason: &str) -> &'static str {
    match reason.contains("UTF-8") {
        true => "save it as UTF-8",
        false => "give the path of a file that exists and may be read",
    }
}

/// Help with XML that is not read.
pub(super) fn of_xml(reason: &str) -> &'static str {
    const HELP: [(&str, &str); 3] = [
        (
            "XML declaration",
            "an XML declaration, `<?xml ...?>`, stands at the very beginning of a file or nowhere: put it before all else, comments and empty \
             lines too, or leave it out",
        ),
        (
            "DTD",
            "leave out `<!DOCTYPE ...>`: it can name other files, and none of a robot's formats needs it",
        ),
        (
            "not a robot file",
            "name a URDF, xacro, SDF or MJCF file, or a description in TOML",
        ),
    ];
    let help = HELP.into_iter().find(|(word, _)| reason.contains(word));
    help.map_or(
        "close every element and quote every attribute",
        |(_, help)| help,
    )
}

/// Help with a xacro file that cannot be expanded.
pub(super) fn of_xacro(reason: &str) -> &'static str {
    match reason.contains(NOT_SET) {
        true => {
            "set the environment variable before the file is read, as a shell does by `NAME=VALUE` before a command"
        }
        false => {
            "repair the place that is named; a file that you trust can be expanded by the xacro of ROS, which runs what stands in it"
        }
    }
}

/// Help with wheels without rollers, by what the file suggests and why.
pub(super) fn of_rollers(rollers: &Proposed, why: Option<&str>) -> String {
    const WHICH: &str = "say which rollers they carry";
    const NOTHING: &str = "nothing in the file says that these are Swedish wheels";
    const ELSE_TYRES: &str = "if they are, say which rollers they carry, and they are put in; else let them roll on tyres";
    match (rollers, why) {
        (Proposed::Contradiction, Some(why)) => {
            format!("{why}; {WHICH} and on which joints, and they are put in")
        }
        (Proposed::Contradiction, None) => format!(
            "they are called mecanum wheels, whose hubs are parallel, and theirs are not: turn the joints so that they are, \
             for gamma is the angle of the rollers and not of the hubs; or {WHICH}, and they are put in"
        ),
        (Proposed::NothingSaid, None) => format!("{NOTHING}; {ELSE_TYRES}"),
        (Proposed::NothingSaid, Some(hint)) => format!("{NOTHING}: {hint}; {ELSE_TYRES}"),
        (Proposed::Rollers(_), Some(why)) => format!("{WHICH}, and they are put in; {why}"),
        (Proposed::Rollers(_), None) => format!("{WHICH}, and they are put in"),
    }
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

#[cfg(test)]
mod tests {
    #[test]
    fn each_fault_has_help_beside_its_message() {
        let source = include_str!("fault.rs");
        let count = |attribute: &str| source.matches(attribute).count();
        assert_eq!(count("#[error("), count("#[diagnostic("));
    }
}
