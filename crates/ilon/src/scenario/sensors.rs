//! `[sensors]`: what the robot knows of its own motion.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Pose and wheel rates as the robot sees them; ideal unless said otherwise.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "SensorsSection")]
pub struct Sensors {
    /// The seed of all noise: the same seed gives the same run.
    pub seed: u64,
    /// Where the pose comes from.
    pub pose: PoseSensor,
    /// Where the wheel rates come from.
    pub encoders: Encoders,
}

/// A sensor that sees the robot's pose, such as a camera.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "PoseSensorSection")]
pub struct PoseSensor {
    /// How often a new pose is taken, in Hz; without it, whenever the guidance asks.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rate_hz: Option<f64>,
    /// How old a pose is when it is seen, in seconds.
    #[schemars(range(min = 0.0))]
    pub latency_s: f64,
    /// Standard deviation of the noise on x and on y, in metres.
    #[schemars(range(min = 0.0))]
    pub position_noise_m: f64,
    /// Standard deviation of the noise on the heading, in degrees.
    #[schemars(range(min = 0.0))]
    pub heading_noise_deg: f64,
}

/// The encoders on the wheels.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "EncodersSection")]
pub struct Encoders {
    /// Standard deviation of the noise on a wheel's rate, in rad/s.
    #[schemars(range(min = 0.0))]
    pub rate_noise_rad_s: f64,
}
