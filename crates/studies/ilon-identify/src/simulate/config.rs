//! The study's settings of the fit by simulation.

use std::collections::BTreeMap;

use ilon_files::defaults::{number, thousandths};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;

/// What is fitted by simulating.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Simulate {
    /// Keys of the scenario that are free, each from a least to a largest value.
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub free: Table,
    /// How long each steady drive of the logs is simulated, in seconds.
    #[serde(default = "number::<3, f64>")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub drive_s: f64,
    /// Whether one common factor on all measured ways is free too: where rows were lost, or the
    /// tracker's scale is not known.
    #[serde(default)]
    pub free_scale: bool,
    /// Ways are believed to no better than this, over the way asked for: what changes from run to
    /// run, and what no value of the free keys explains. Where a model misses by more than the logs
    /// scatter, an honest figure keeps the few drives that scatter least from deciding all.
    #[serde(default = "thousandths::<3>")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub least_error: f64,
    /// At which angles of their rollers the wheels of a drive began, which most logs do not say:
    /// they count from wherever the wheels stood. Left out, any: where that changes what is found,
    /// each drive is simulated from eight sets of angles spread evenly, the mean is compared, and
    /// what the sets scatter by counts as an error of the drive. A number says how many sets; 1
    /// that wheels begin as the robot's file has them. `"log"`: the log's wheel angles are those of
    /// absolute encoders, and 0 is where the robot's file has the wheel (see `zero` of a column).
    pub phases: Option<Phases>,
    /// What wheels and body do once a roller is compared too.
    pub ripple: Option<RippleFile>,
    /// How the drift of the heading is compared; left out, it is shown and not fitted.
    pub heading: Option<HeadingFile>,
    /// How the currents of the log's motors are compared, as torques of the wheels; left out, they
    /// are not.
    pub currents: Option<CurrentsFile>,
    /// Other values of keys that are simulated beside what is fitted, without being fitted
    /// themselves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<BesideFile>,
    /// Most steps of the search.
    #[serde(default = "number::<12, u32>")]
    #[schemars(range(min = 1, max = 1000))]
    pub steps: u32,
}

/// What is known of the angles at which wheels begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Phases {
    /// Nothing: so many sets of angles are simulated. With 1, wheels begin as the robot's file has
    /// them.
    Count(#[schemars(range(min = 1, max = 1000))] u32),
    /// The log has them.
    Logged(Logged),
}

/// The word for angles that the log has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Logged {
    /// Wheel angles of the log are those of the robot's file.
    Log,
}

/// How the ripple of a log is compared with that of a simulation: the amplitudes of the wheels'
/// rates and of the body's way at the rate at which rollers pass.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RippleFile {
    /// Over how long a stretch an amplitude is taken, in seconds, less than `drive_s`: some five
    /// rollers of the slowest wheel.
    #[serde(default = "thousandths::<2500>")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stretch_s: f64,
    /// Wheels whose rollers touch in phase, as far as that is known, in groups of their names:
    /// where left and right wheels of an axle are in phase, the body ripples along its way and not
    /// across it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub together: Vec<Vec<String>>,
}

/// How the heading's drift is compared: by how much the robot turns beyond what its wheels ask for,
/// over the way that they ask for.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeadingFile {
    /// Whether the free keys are fitted to it too, and not to the ways alone.
    #[serde(default)]
    pub fitted: bool,
    /// It is believed to no better than this, in rad/m.
    #[serde(default = "thousandths::<30>")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub least_error_rad_per_m: f64,
}

/// How a motor's current I becomes the torque on its wheel: (k I - f) n, against the motor's own
/// friction f.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurrentsFile {
    /// k: torque of the motor for its current, in N m/A.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub torque_constant_n_m_a: f64,
    /// f: friction of the motor and its gear at the motor, in N m.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub friction_n_m: f64,
    /// n: turns of the motor for a turn of the wheel; left out, what the robot's file says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub gear_ratio: Option<f64>,
    /// Whether the log has the size of the currents alone: the motors are then taken to push as
    /// their wheels turn.
    #[serde(default)]
    pub unsigned: bool,
    /// Whether the free keys are fitted to the torques too, and not to the ways alone.
    #[serde(default)]
    pub fitted: bool,
    /// Torques are believed to no better than this, in N m at the wheel.
    #[serde(default = "thousandths::<20>")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub least_error_n_m: f64,
}

/// Other values of keys, simulated beside what was fitted.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BesideFile {
    /// What it is called.
    pub name: String,
    /// The keys that are otherwise, of the scenario or of the robot's description below
    /// `robot.spec`.
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: Table,
}
