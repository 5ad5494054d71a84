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
    /// An inertial measurement unit; without it the robot does not know how it leans.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub imu: Option<Imu>,
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
    /// Takes the turn from the gyroscope of `[sensors.imu]` in place of the wheels.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub gyroscope: bool,
}

impl Default for Fusion {
    fn default() -> Self {
        Self {
            position_drift_m: 0.01,
            heading_drift_deg: 1.0,
            gyroscope: false,
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "EncodersSection")]
pub struct Encoders {
    /// Standard deviation of the noise on a wheel's rate, in rad/s.
    #[schemars(range(min = 0.0))]
    pub rate_noise_rad_s: f64,
    /// Counts in a turn of a wheel, all edges counted: angles come in such steps, and a rate is what was counted in the last control period over that
    /// period. Left out, angles and rates are exact but for their noise.
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

/// An inertial measurement unit on the chassis: rates of turn, accelerations, and by a complementary filter which way is down. Ideal unless
/// said otherwise. What it says is the mean over the time since it said the last.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "ImuSection")]
pub struct Imu {
    /// How often it says something, in Hz; without it, once a control period.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rate_hz: Option<f64>,
    /// How old what it says is when it is seen, in seconds.
    #[schemars(range(min = 0.0))]
    pub latency_s: f64,
    /// Where it sits along the body's x axis, in metres.
    pub x_m: f64,
    /// Where it sits along the body's y axis, in metres.
    pub y_m: f64,
    /// Where it sits along the body's z axis, in metres.
    pub z_m: f64,
    /// By how much it is mounted rolled, which the robot does not know, in degrees.
    pub roll_deg: f64,
    /// By how much it is mounted pitched, which the robot does not know, in degrees.
    pub pitch_deg: f64,
    /// Time constant of the filter that makes a tilt of rates and accelerations, in seconds.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub filter_s: f64,
    /// What the accelerometer measures wrong, in m/s^2.
    pub accelerometer: ImuNoise,
    /// What the gyroscope measures wrong, in rad/s.
    pub gyroscope: ImuNoise,
}

impl Default for Imu {
    fn default() -> Self {
        Self {
            rate_hz: None,
            latency_s: 0.0,
            x_m: 0.0,
            y_m: 0.0,
            z_m: 0.0,
            roll_deg: 0.0,
            pitch_deg: 0.0,
            filter_s: 1.0,
            accelerometer: ImuNoise::default(),
            gyroscope: ImuNoise::default(),
        }
    }
}

/// What an inertial sensor measures wrong, on each of its axes: standard deviations in the sensor's own unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "ImuNoiseSection")]
pub struct ImuNoise {
    /// Of the noise of a sample.
    #[schemars(range(min = 0.0))]
    pub noise: f64,
    /// Of the bias at the start, drawn by the seed.
    #[schemars(range(min = 0.0))]
    pub bias: f64,
    /// By how much the bias has walked after a second; it grows with the root of the time.
    #[schemars(range(min = 0.0))]
    pub bias_walk: f64,
}
