//! Options of reading that repair a fault.

use std::path::PathBuf;

use crate::options::{LoadOptions, RollerForms, WheelOptions};
use crate::packages::Package;

/// An option of reading that repairs a fault, to be expressed by front ends.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Remedy {
    /// [`LoadOptions::repair`]: enable repairs.
    Repair,
    /// [`LoadOptions::leave_out_missing`]: leave out what is missing.
    LeaveOutMissing,
    /// [`LoadOptions::packages`]: set a package's folder.
    Package {
        /// Its name.
        name: String,
        /// The folder that contains its missing files, if there is one.
        folder: Option<PathBuf>,
    },
    /// [`LoadOptions::arguments`]: set a xacro argument.
    Argument {
        /// Its name.
        name: String,
        /// A value with which the file models something that it does not with others.
        value: Option<String>,
    },
    /// [`LoadOptions::rollers`]: use the shapes of the rollers' file.
    AsModelled,
    /// [`LoadOptions::wheels`]: add rollers to bare wheels.
    Rollers(Box<WheelOptions>),
    /// [`LoadOptions::wheels`]: state the rollers of bare wheels, for which the file gives no
    /// information.
    WhichRollers {
        /// The possible wheel joints.
        wheels: Vec<String>,
        /// Whether their hubs are parallel, like those of mecanum wheels.
        parallel: bool,
    },
    /// [`LoadOptions::wheel_radius_m`]: state the size of the wheels.
    WheelRadius {
        /// The radius on which the file's clues agree, in metres.
        guess_m: Option<f64>,
    },
}

impl Remedy {
    /// Whether it adds something that the file does not model.
    pub(crate) fn is_guess(&self) -> bool {
        matches!(self, Self::Rollers(_) | Self::WheelRadius { .. })
    }

    /// Whether only the user knows the answer, and the robot cannot be read without it.
    pub(crate) fn is_asked(&self) -> bool {
        matches!(
            self,
            Self::WhichRollers { .. }
                | Self::WheelRadius { guess_m: None }
                | Self::Argument { value: None, .. }
        )
    }

    /// Returns the options with the remedy applied; `None` if only the user knows the answer, or if
    /// nothing changes.
    pub fn apply(&self, options: &LoadOptions) -> Option<LoadOptions> {
        let mut remedied = options.clone();
        match self {
            Self::Repair => remedied.repair = true,
            Self::LeaveOutMissing => remedied.leave_out_missing = true,
            Self::AsModelled => remedied.rollers = RollerForms::AsModelled,
            Self::Rollers(rollers) => {
                let known = options.wheels.as_ref();
                let mut rollers = (**rollers).clone();
                // A user's value is kept.
                if let Some(known) = known {
                    rollers.roller_radius_m = known.roller_radius_m;
                    rollers.roller_mass_kg = known.roller_mass_kg;
                    rollers.rollers = known.rollers;
                }
                remedied.wheels = Some(rollers);
            }
            Self::WheelRadius { guess_m } => {
                if options.wheel_radius_m.is_some() {
                    return None;
                }
                remedied.wheel_radius_m = Some((*guess_m)?);
            }
            Self::Argument { name, value } => {
                let value = value.clone()?;
                remedied.arguments.insert(name.clone(), value);
            }
            Self::Package {
                name,
                folder: Some(folder),
            } => {
                let package = Package {
                    name: name.clone(),
                    folder: folder.clone(),
                };
                if !remedied.packages.contains(&package) {
                    remedied.packages.push(package);
                }
            }
            Self::Package { folder: None, .. } | Self::WhichRollers { .. } => return None,
        }
        (remedied != *options).then_some(remedied)
    }
}
