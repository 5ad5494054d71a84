//! `[robot]`: which robot, and how it starts.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which robot, and how it starts.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "RobotSection")]
pub struct Robot {
    /// The robot's URDF, relative to the scenario file.
    pub file: PathBuf,
    /// Where it starts: x of the body's origin in the world, in metres.
    #[serde(default)]
    pub x_m: f64,
    /// Where it starts: y of the body's origin in the world, in metres.
    #[serde(default)]
    pub y_m: f64,
    /// Where it looks at the start: the angle from the world's x axis to the body's, in degrees, counter-clockwise.
    #[serde(default)]
    pub heading_deg: f64,
    /// Which rollers are bodies of their own in the simulated world.
    #[serde(default)]
    pub roller_bodies: RollerBodies,
}

/// Which rollers are bodies of their own in the simulated world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RollerBodies {
    /// Every roller, always.
    #[default]
    All,
    /// Those that can touch something; the others keep their spin without a body. Faster.
    Near,
}
