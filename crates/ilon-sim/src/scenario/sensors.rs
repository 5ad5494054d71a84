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
    /// Joins poses and wheel odometry in an extended Kalman filter, each pose at the time at which it was taken. Without
    /// it the robot takes the newest pose that has arrived for its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fusion: Option<Fusion>,
}

/// How far the filter trusts the wheels. How far it trusts the poses is their own noise.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "FusionSection")]
pub struct Fusion {
    /// Standard deviation of x, and y, by odometry after the wheels have rolled 1 m, in metres; it grows with the root of
    /// the way.
    #[schemars(range(min = 0.0))]
    pub position_drift_m: f64,
    /// Standard deviation of the heading by odometry after the wheels have rolled 1 m, in degrees.
    #[schemars(range(min = 0.0))]
    pub heading_drift_deg: f64,
}

impl Default for Fusion {
    fn default() -> Self {
        Self {
            position_drift_m: 0.01,
            heading_drift_deg: 1.0,
        }
    }
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
