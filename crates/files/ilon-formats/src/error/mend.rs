//! What a fault is about, and which options of reading repair it.

use super::fault::Fault;
use super::help::{is_of_names, is_zero_size};
use super::named::{MissingFile, Proposed};
use super::remedy::Remedy;
use crate::options::{Handedness, LoadOptions, WheelOptions};

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
        let mut others: Vec<&str> = others.collect();
        others.sort_unstable();
        let alike = others
            .iter()
            .map(|other| (strsim::jaro_winkler(joint, other), other));
        let best = alike.max_by(|a, b| a.0.total_cmp(&b.0));
        let near = best.filter(|(likeness, _)| *likeness > ALIKE);
        Self::UnknownJoint {
            joint: joint.to_owned(),
            near: near.map(|(_, name)| (*name).to_owned()),
            others: others.iter().map(|name| (*name).to_owned()).collect(),
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
