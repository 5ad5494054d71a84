//! `[sensors]`: the robot's measurements of its own motion.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

/// Pose and wheel rates as the robot sees them; ideal by default.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "SensorsSection")]
pub struct Sensors {
    /// Seed of all noise: the same seed gives the same run.
    pub seed: u64,
    /// Where the pose comes from.
    pub pose: PoseSensor,
    /// Where the wheel rates come from.
    pub encoders: Encoders,
    /// Inertial measurement unit; without it the robot does not know its tilt.
    pub imu: Option<Imu>,
    /// Extended Kalman filter of poses and wheel odometry, each pose at the time when it was taken.
    /// Without it the robot uses the newest pose.
    pub fusion: Option<Fusion>,
}

/// How far the filter trusts the wheels. How far it trusts the poses is their own noise.
#[derive(Clone, Debug, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "FusionSection")]
pub struct Fusion {
    /// Standard deviation of the odometry's x and y after 1 m, in metres; it grows with the square
    /// root of the distance.
    #[schemars(range(min = 0.0))]
    #[default = 0.01]
    pub position_drift_m: f64,
    /// Standard deviation of the odometry's heading after 1 m, in degrees.
    #[schemars(range(min = 0.0))]
    #[default = 1.0]
    pub heading_drift_deg: f64,
    /// Yaw rate from the gyroscope of `[sensors.imu]` instead of the wheels.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub gyroscope: bool,
}

/// A pose sensor, such as a camera.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "PoseSensorSection")]
pub struct PoseSensor {
    /// Sample rate, in Hz [default: each control period].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rate_hz: Option<f64>,
    /// Delay, in seconds.
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "EncodersSection")]
pub struct Encoders {
    /// Standard deviation of the noise on a wheel's rate, in rad/s.
    #[schemars(range(min = 0.0))]
    pub rate_noise_rad_s: f64,
    /// Counts in a turn of a wheel, all edges counted; a rate is the counts of the last control
    /// period over that period, and wheel loops are sampled with it [default: exact].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0))]
    pub counts_per_turn: Option<f64>,
    /// Time constant of a first-order filter on counted rates, in seconds; 0 for none.
    #[schemars(range(min = 0.0))]
    #[serde(skip_serializing_if = "is_zero")]
    pub rate_filter_s: f64,
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// An inertial measurement unit on the chassis: rates, accelerations, and tilt by a complementary
/// filter, as means since its last sample. Ideal by default.
#[derive(Clone, Debug, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "ImuSection")]
pub struct Imu {
    /// Sample rate, in Hz [default: once a control period].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rate_hz: Option<f64>,
    /// Delay, in seconds.
    #[schemars(range(min = 0.0))]
    pub latency_s: f64,
    /// x in the body frame, in metres.
    pub x_m: f64,
    /// y in the body frame, in metres.
    pub y_m: f64,
    /// z in the body frame, in metres.
    pub z_m: f64,
    /// Roll of its mounting, unknown to the robot, in degrees.
    pub roll_deg: f64,
    /// Pitch of its mounting, unknown to the robot, in degrees.
    pub pitch_deg: f64,
    /// Time constant of the tilt filter, in seconds.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    #[default = 1.0]
    pub filter_s: f64,
    /// Errors of the accelerometer, in m/s^2.
    pub accelerometer: ImuNoise,
    /// Errors of the gyroscope, in rad/s.
    pub gyroscope: ImuNoise,
}

/// Errors on each axis, as standard deviations in the sensor's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "ImuNoiseSection")]
pub struct ImuNoise {
    /// Of the noise of a sample.
    #[schemars(range(min = 0.0))]
    pub noise: f64,
    /// Of the constant bias.
    #[schemars(range(min = 0.0))]
    pub bias: f64,
    /// Of the bias after one second of random walk.
    #[schemars(range(min = 0.0))]
    pub bias_walk: f64,
}
