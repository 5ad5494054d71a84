//! `[controller.robot]`: what the controller believes of the robot.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checks::objection::{Objection, object_if};

/// What the controller believes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "ControllerSection")]
pub struct Controller {
    /// What it believes of the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<Believed>,
}

/// What the controller believes wrongly of the robot. Commands, dead reckoning, fusion and the
/// model of a torque law use the believed robot; physics and default gains use the real one.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "BelievedRobotSection")]
pub struct Believed {
    /// The file of another robot, relative to the scenario, whose wheels are believed. Wheels are
    /// matched by name where all names are the same, else in the order of the files.
    pub file: Option<PathBuf>,
    /// The radius of all wheels, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub wheel_radius_m: Option<f64>,
    /// The lever of all wheels in turns, in metres: l_x + l_y of mecanum wheels at 45 degrees, the
    /// distance from the origin of omni wheels. Wheels move along the line from the body's origin.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub lever_m: Option<f64>,
    /// The angle gamma of all wheels, in degrees, each with its own sign; a negative one exchanges
    /// the signs, as if left and right were confused.
    pub gamma_deg: Option<f64>,
    /// x of the body's origin in the body frame, in metres.
    pub origin_x_m: f64,
    /// y of the body's origin in the body frame, in metres.
    pub origin_y_m: f64,
    /// The heading of its front from the body's x axis, in degrees, counter-clockwise.
    pub origin_heading_deg: f64,
    /// Single wheels, by their joints.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub wheels: BTreeMap<String, BelievedWheel>,
}

/// What the controller believes of one wheel.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "BelievedWheelSection")]
pub struct BelievedWheel {
    /// The wheel whose commands and encoder it has, as with exchanged cables. Each wheel is taken
    /// for one.
    pub taken_for: Option<String>,
    /// Its radius, in metres.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_m: Option<f64>,
    /// x of its middle in the body frame, in metres.
    pub x_m: Option<f64>,
    /// y of its middle in the body frame, in metres.
    pub y_m: Option<f64>,
    /// Hub axis, in degrees from the body's x axis, counter-clockwise; 90 for a wheel that drives
    /// ahead.
    pub axis_deg: Option<f64>,
    /// Its angle gamma, in degrees, with its sign.
    pub gamma_deg: Option<f64>,
    /// Motor and encoder turn the other way.
    pub reversed: bool,
}

impl Controller {
    /// Whether it is empty.
    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Refuses two wheels that are taken for the same one.
    pub(super) fn object(&self) -> Result<(), Objection> {
        let wheels = self.robot.iter().flat_map(|robot| &robot.wheels);
        let taken = wheels.filter_map(|(name, wheel)| Some((name, wheel.taken_for.as_ref()?)));
        let names: BTreeSet<&String> = taken.clone().map(|(name, _)| name).collect();
        let mut others = BTreeSet::new();
        for (name, other) in taken {
            let key = format!("controller.robot.wheels.{name}.taken_for");
            object_if!(
                !names.contains(other),
                "{key}",
                "`{name}` is taken for `{other}`, and so is `{other}` itself",
                "say what `{other}` is taken for, such as `[controller.robot.wheels.{other}] taken_for = \"{name}\"`",
            );
            object_if!(
                !others.insert(other),
                "{key}",
                "two wheels are taken for `{other}`",
                "take each wheel for another one",
            );
        }
        Ok(())
    }
}
