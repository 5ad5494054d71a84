//! The content of a study's file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use ilon_files::defaults::number;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;

use crate::log::Format;
use crate::simulate::Simulate;

/// An identification as it stands in its file. Paths are relative to the file.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "IdentifyStudy")]
pub struct StudyFile {
    /// The robot as known so far: its description in TOML, or any file that a scenario can
    /// name.
    pub robot: PathBuf,
    /// Keys of the scenario in which the robot is simulated, and of `[robot]` where its file needs
    /// more to be read.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: Table,
    /// How the logs are written.
    pub log: Format,
    /// The logs.
    pub runs: Vec<RunFile>,
    /// Over how long a stretch displacements are compared, in seconds.
    #[serde(default = "number::<1, f64>")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub window_s: f64,
    /// What of the tracker is not known, beside the parameters of the models: `"x_m"` and `"y_m"`
    /// of the point that it follows, in the body frame, and `"heading_deg"`, by which its heading
    /// is ahead of the body's.
    #[serde(default = "tracker")]
    pub tracker: Vec<String>,
    /// Models of the kinematics, each with what is free in it. The one with the least error on what
    /// was not fitted is chosen.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub models: Vec<ModelFile>,
    /// Keys of the scenario that are fitted by simulating the runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulate: Option<Simulate>,
    /// The seed of the sets of wheel angles from which drives are simulated.
    #[serde(default)]
    pub seed: u32,
}

/// One log, or a part of one.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunFile {
    /// The file of the log.
    pub file: PathBuf,
    /// Kept back: nothing is fitted to it, and models are judged by it.
    #[serde(default)]
    pub held_out: bool,
    /// Runs of one series share how the tracker saw the robot.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub series: String,
    /// How much of the beginning is left out, in seconds.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub from_s: f64,
    /// Where it ends, in seconds from the log's beginning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub to_s: Option<f64>,
}

/// A model of the kinematics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// What it is called.
    pub name: String,
    /// Its parameters: `"radius_m"`, `"radius_m.WHEEL"` or `"radius_m.*"`, `"lever_m"`,
    /// `"gamma_deg"`, `"axis_deg.WHEEL"`, `"steering_deg.WHEEL"`, `"x_m.WHEEL"`, `"y_m.WHEEL"`,
    /// `"gain.ahead"`, `"gain.sideways"`, `"gain.turn"`, `"rows_lost"`.
    pub free: Vec<String>,
}

fn tracker() -> Vec<String> {
    ["x_m", "y_m", "heading_deg"].map(str::to_owned).to_vec()
}
