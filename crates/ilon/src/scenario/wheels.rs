//! `[wheel_loop]` and `[motors]`: from wheel rates asked for to torques.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A PID on each wheel's rate. Gains left out are derived from the robot's own inertia.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "WheelLoopSection")]
pub struct WheelLoop {
    /// Torque per rate error, in N m s/rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub proportional_n_m_s_per_rad: Option<f64>,
    /// Torque per angle error, in N m/rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub integral_n_m_per_rad: Option<f64>,
    /// Torque per rate of the rate error, in N m s^2/rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub derivative_n_m_s2_per_rad: Option<f64>,
}

/// What the motors can do, beyond the `effort` and `velocity` of the URDF, which always hold.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "MotorsSection")]
pub struct Motors {
    /// The torque-speed curve of a direct-current motor with its gear; without it, only the URDF's limits hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dc: Option<DcMotor>,
}

/// A direct-current motor at the wheel: its torque falls linearly with its rate.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "DcMotorSection")]
pub struct DcMotor {
    /// Torque at standstill, at the wheel, in N m.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stall_torque_n_m: f64,
    /// Rate without load, at the wheel, in rad/s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub no_load_rate_rad_s: f64,
}
