//! Options of reading that repair a fault.

use std::path::PathBuf;

use crate::options::{LoadOptions, RollerForms, WheelOptions};
use crate::packages::Package;

/// An option of reading that would repair a fault. Front ends word it their own way.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Remedy {
    /// [`LoadOptions::repair`]: let it be repaired.
    Repair,
    /// [`LoadOptions::leave_out_missing`]: go without what is missing.
    LeaveOutMissing,
    /// [`LoadOptions::packages`]: say where a package lies.
    Package {
        /// Its name.
        name: String,
        /// The folder that holds what is missing of it, if there is one.
        folder: Option<PathBuf>,
    },
    /// [`LoadOptions::arguments`]: give a xacro argument a value.
    Argument {
        /// Its name.
        name: String,
        /// A value with which the file models what it does not with others.
        value: Option<String>,
    },
    /// [`LoadOptions::rollers`]: take the rollers with the shapes of their file.
    AsModelled,
    /// [`LoadOptions::wheels`]: put rollers into bare wheels.
    Rollers(Box<WheelOptions>),
    /// [`LoadOptions::wheels`]: say which rollers bare wheels carry, of which the file says nothing.
    WhichRollers {
        /// The joints that could be wheels.
        wheels: Vec<String>,
        /// Whether their hubs are parallel, as those of mecanum wheels are.
        parallel: bool,
    },
    /// [`LoadOptions::wheel_radius_m`]: say how large the wheels are.
    WheelRadius {
        /// The radius on which clues in the file agree, in metres.
        guess_m: Option<f64>,
    },
}

impl Remedy {
    /// Whether it brings in something that the file does not model.
    pub(crate) fn is_guess(&self) -> bool {
        matches!(self, Self::Rollers(_) | Self::WheelRadius { .. })
    }

    /// Whether only a person knows what to say, and the robot cannot be read before it is said.
    pub(crate) fn is_asked(&self) -> bool {
        matches!(
            self,
            Self::WhichRollers { .. }
                | Self::WheelRadius { guess_m: None }
                | Self::Argument { value: None, .. }
        )
    }

    /// The options with the remedy in them; `None` where only a person knows what to say, or where it changes nothing.
    pub fn apply(&self, options: &LoadOptions) -> Option<LoadOptions> {
        let mut remedied = options.clone();
        match self {
            Self::Repair => remedied.repair = true,
            Self::LeaveOutMissing => remedied.leave_out_missing = true,
            Self::AsModelled => remedied.rollers = RollerForms::AsModelled,
            Self::Rollers(rollers) => {
                let known = options.wheels.as_ref();
                let mut rollers = (**rollers).clone();
                // What a person said stays.
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
