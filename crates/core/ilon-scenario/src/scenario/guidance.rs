//! `[guidance]`: how the robot tracks its reference.

use ilon_control::{GuidanceTask, Priority};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

/// The guidance law of Indiveri 2009, section III.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "GuidanceSection")]
pub struct Guidance {
    /// Task that keeps its wheel rates in saturation [default: position; of a twist in open loop,
    /// both give way together].
    pub priority: Option<Priority>,
    /// What is done with wheel rates above the limit.
    pub saturation: Saturation,
    /// Gain on the position error, K_r of equation (26), in 1/s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    #[default = 1.0]
    pub position_gain_per_s: f64,
    /// Gain on the heading error, K_phi of equation (26), in 1/s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    #[default = 1.0]
    pub heading_gain_per_s: f64,
    /// Largest commanded wheel rate, in rad/s [default: the lowest velocity limit in the URDF].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub wheel_rate_limit_rad_s: Option<f64>,
    /// Gain on the position error as a symmetric positive definite matrix in the world frame, in
    /// 1/s: `[[xx, xy], [xy, yy]]`. Instead of `position_gain_per_s`.
    pub position_gain_matrix_per_s: Option<[[f64; 2]; 2]>,
    /// Capacity of all tasks together, c_1 of equation (34), in rad/s [default: the wheel rate
    /// limit].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub capacity_rad_s: Option<f64>,
    /// Largest commanded rate of each wheel, in rad/s, in the robot's order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wheel_rate_limits_rad_s: Vec<f64>,
    /// Tasks in the order of priority, equations (32) to (34), instead of `priority`. Tasks that
    /// are not listed are not done.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tasks: Vec<GuidanceTask>,
    /// Kinematics from twist to wheel rates: ideal, or of the rollers that touch.
    pub kinematics: Kinematics,
    /// Point of the body that follows the reference.
    pub reference_point: ReferencePoint,
}

impl Guidance {
    /// The largest gain on a position error over all directions, in 1/s.
    pub fn position_gain_most_per_s(&self) -> f64 {
        match self.position_gain_matrix_per_s {
            // The larger eigenvalue of a symmetric matrix.
            Some([[xx, xy], [_, yy]]) => 0.5 * (xx + yy) + libm::hypot(0.5 * (xx - yy), xy),
            None => self.position_gain_per_s,
        }
    }
}

/// A point of the body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ReferencePoint {
    /// The origin of the body frame.
    #[default]
    Origin,
    /// The point at which position and heading are decoupled: M_a is orthogonal to span(M_l). `ilon
    /// inspect` prints it.
    Decoupling,
    /// Any point.
    At {
        /// x in the body frame, in metres.
        x_m: f64,
        /// y in the body frame, in metres.
        y_m: f64,
    },
}

/// What is done with wheel rates above the limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Saturation {
    /// The lower task gives way, equations (33)-(34).
    #[default]
    Prioritised,
    /// Each wheel is held to its limit by itself, which bends the motion.
    Clip,
    /// All wheel rates are scaled down together, which slows both tasks.
    Scale,
    /// Nothing: the rates are commanded as they come, and the motors do what they can.
    None,
}

/// Kinematics from twist to wheel rates: ideal, or of the rollers that touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kinematics {
    /// Equation (7): every wheel as if its touching roller pointed straight down.
    #[default]
    Ideal,
    /// The roller that really touches, so that the ripple of few rollers is cancelled.
    Contact,
}
