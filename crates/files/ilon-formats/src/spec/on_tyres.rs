//! The short description of a robot on tyres: differential, skid-steered, tricycle, swerve.

use std::collections::BTreeSet;
use std::path::Path;

use ilon_files::defaults::{number, yes};
use ilon_files::toml::decode_text;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;

use super::check::refused;
use super::ranges::out_of_range;
use super::reading::{placed, read};
use super::{ChassisSpec, MAX_BYTES, exactly, ranges};
use crate::error::{Fault, RobotError};
use crate::files::FileAccess;

/// The table that only such a description has.
const TYRES: &str = "tyres";

/// A robot on tyres in short: one chassis, and wheels without rollers that are alike but for place,
/// radius, axis, drive and steering.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "RobotOnTyres")]
#[non_exhaustive]
pub struct SpecOnTyres {
    /// The robot's name.
    pub name: String,
    /// The body that carries the wheels.
    pub chassis: ChassisSpec,
    /// What all wheels have in common.
    pub tyres: TyreSpec,
    /// The steering of wheels with `steered = true`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steering: Option<SteeringSpec>,
    /// `[[wheels]]`: the wheels one by one.
    pub wheels: Vec<TyredWheel>,
    /// `[[casters]]`: wheels that swivel and roll freely.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub casters: Vec<CasterSpec>,
}

/// A wheel on a tyre: a solid cylinder with rounded shoulders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct TyreSpec {
    /// From the axle to the ground, in metres.
    pub radius_m: f64,
    /// Width of the tyre, in metres.
    pub width_m: f64,
    /// Radius of the tyre's shoulders, in metres, below half of its width [default: an eighth of
    /// the width].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shoulder_radius_m: Option<f64>,
    /// Mass of a wheel, in kg.
    pub mass_kg: f64,
    /// Largest torque of the motor at the wheel, behind its gear, in N m.
    pub motor_effort_n_m: f64,
    /// Largest rate of the motor at the wheel, behind its gear, in rad/s.
    pub motor_velocity_rad_s: f64,
    /// Viscous damping of the wheel's bearing and gear, in N m s/rad.
    #[serde(default)]
    pub damping_n_m_s: f64,
    /// Dry friction of the wheel's bearing and gear, in N m.
    #[serde(default)]
    pub friction_n_m: f64,
}

/// The steering of a wheel: a servo about an upright axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct SteeringSpec {
    /// Mass of the fork that holds a wheel, in kg, on the steering axis.
    pub fork_mass_kg: f64,
    /// Largest torque of the servo, in N m.
    pub effort_n_m: f64,
    /// Largest rate of the servo, in rad/s.
    pub velocity_rad_s: f64,
    /// How far it turns to each side, in degrees [default: all around].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_deg: Option<f64>,
    /// How far the wheel's middle stands behind the steering axis as the wheel points ahead, in
    /// metres.
    #[serde(default)]
    pub trail_m: f64,
}

/// One wheel on a tyre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct TyredWheel {
    /// The name of its joint. Its steering joint is `NAME_steer`.
    pub name: String,
    /// Its middle in the body frame, x and y, in metres, as its steering points ahead.
    #[serde(deserialize_with = "exactly")]
    pub position_m: [f64; 2],
    /// From its axle to the ground, in metres, if it differs from the others'.
    pub radius_m: Option<f64>,
    /// The hub axis as an angle from the body's x axis, counter-clockwise, in degrees: at 90 a
    /// positive rate drives ahead.
    #[serde(default = "number::<90, f64>")]
    pub axis_deg: f64,
    /// Whether a motor drives it.
    #[serde(default = "yes")]
    pub driven: bool,
    /// Whether `[steering]` turns it.
    #[serde(default)]
    pub steered: bool,
}

/// A caster.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct CasterSpec {
    /// Its name: its joints are `NAME_caster_swivel` and `NAME_caster_roll`.
    pub name: String,
    /// Its swivel axis in the body frame, x and y, in metres.
    #[serde(deserialize_with = "exactly")]
    pub position_m: [f64; 2],
    /// Radius of its wheel, in metres.
    pub radius_m: f64,
    /// Width of its wheel, in metres.
    pub width_m: f64,
    /// Mass of its wheel, in kg.
    pub mass_kg: f64,
    /// Mass of its fork, in kg, on the swivel axis.
    pub fork_mass_kg: f64,
    /// How far its wheel stands behind the swivel axis, in metres.
    pub trail_m: f64,
}

/// Whether a text in TOML describes a robot on tyres. Of a text that is no TOML another reader says
/// so.
pub(crate) fn is_on_tyres(text: &str) -> bool {
    decode_text::<Table>(text).is_ok_and(|table| table.contains_key(TYRES))
}

impl SpecOnTyres {
    /// The JSON Schema of the file.
    pub fn json_schema() -> serde_json::Value {
        schemars::schema_for!(Self).to_value()
    }

    /// Reads a description from a TOML file; `None` for one that has no `[tyres]`.
    ///
    /// # Errors
    /// A file that cannot be read; TOML that is of another form, or has unknown keys.
    pub fn load(path: impl AsRef<Path>) -> Result<Option<Self>, RobotError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let read = FileAccess::anywhere().read_text(path, MAX_BYTES);
        let text = read.map_err(|e| RobotError::new(&file, Fault::unreadable(e)))?;
        let is_on_tyres = is_on_tyres(&text);
        is_on_tyres
            .then(|| Self::from_toml_str_with(&text, &file, &Table::new()))
            .transpose()
    }

    /// Reads a description from TOML with changed keys, see [`crate::LoadOptions::spec`].
    ///
    /// # Errors
    /// TOML of another form, unknown keys and invalid values.
    pub(crate) fn from_toml_str_with(
        text: &str,
        file: &str,
        changes: &Table,
    ) -> Result<Self, RobotError> {
        let spec: Self = read(text, file, changes)?;
        let faults = spec.faults().into_iter();
        let checked = refused(faults.map(|fault| RobotError::new(&spec.name, fault)));
        checked.map_err(|error| placed(error, text, file, changes))?;
        Ok(spec)
    }

    /// The values that are out of their ranges, by their keys. What a tyre can be made of is
    /// checked by then.
    fn faults(&self) -> Vec<Fault> {
        let mut faults = ranges::faults(self);
        faults.extend(self.faults_of_steering());
        faults.extend(self.faults_of_names());
        faults
    }

    fn faults_of_steering(&self) -> Vec<Fault> {
        if self.steering.is_some() {
            return Vec::new();
        }
        let steered = self.wheels.iter().enumerate();
        let steered = steered.filter(|(_, wheel)| wheel.steered);
        let range = "false where there is no `[steering]`";
        steered
            .map(|(index, _)| out_of_range(&format!("wheels.{index}.steered"), true, range))
            .collect()
    }

    /// The faults of the wheels' names.
    fn faults_of_names(&self) -> Vec<Fault> {
        let wheels = self.wheels.iter().map(|wheel| &wheel.name).enumerate();
        let casters = self.casters.iter().map(|caster| &caster.name).enumerate();
        let casters = casters.map(|of| ("casters", of));
        let all = wheels.map(|of| ("wheels", of)).chain(casters);
        let mut known = BTreeSet::new();
        let taken =
            all.filter(|(_, (_, name))| name.is_empty() || *name == "base" || !known.insert(*name));
        let range = "a name that no other wheel or caster has";
        taken
            .map(|(list, (index, name))| {
                out_of_range(&format!("{list}.{index}.name"), format!("`{name}`"), range)
            })
            .collect()
    }
}
