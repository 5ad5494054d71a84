//! `[robot.joints.NAME]`: what joints that are neither a wheel's nor a roller's do.

use ilon_formats::{JointOptions, RoleOption};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a joint does that is neither a wheel's nor a roller's. Of two keys for the same, that with `rad` is for a joint that turns, or with
/// `n_m` for its torques; the other is for one that slides.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "RobotJointSection")]
pub struct Joint {
    /// Its role; left out, sprung where a stiffness is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub role: Option<JointRole>,
    /// Stiffness of its spring where it slides, in N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stiffness_n_m: Option<f64>,
    /// Stiffness of its spring where it turns, in N m/rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stiffness_n_m_rad: Option<f64>,
    /// Viscous damping where it slides, in N s/m [default: the robot's file].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub damping_n_s_m: Option<f64>,
    /// Viscous damping where it turns, in N m s/rad [default: the robot's file].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub damping_n_m_s_rad: Option<f64>,
    /// Where the spring acts with its preload alone, where the joint slides, in metres [default: 0].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_m: Option<f64>,
    /// Where the spring acts with its preload alone, where the joint turns, in radians [default: 0].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_rad: Option<f64>,
    /// The spring's force on the body at its rest, along the joint's axis, in N [default: 0].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preload_n: Option<f64>,
    /// The spring's torque on the body at its rest, about the joint's axis, in N m [default: 0].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preload_n_m: Option<f64>,
    /// Dry friction where it slides, in N [default: the robot's file].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub friction_n: Option<f64>,
    /// Dry friction where it turns, in N m [default: the robot's file].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub friction_n_m: Option<f64>,
}

/// What acts in a joint beside its damping and friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "RobotJointRole")]
pub enum JointRole {
    /// Nothing: a rocker.
    Free,
    /// A spring.
    Sprung,
    /// It does not move.
    Held,
}

impl Joint {
    /// As the robot's file is read with it.
    pub(super) fn options(&self) -> JointOptions {
        let role = self.role.map(|role| match role {
            JointRole::Free => RoleOption::Free,
            JointRole::Sprung => RoleOption::Sprung,
            JointRole::Held => RoleOption::Held,
        });
        JointOptions {
            role,
            stiffness_n_m: self.stiffness_n_m,
            stiffness_n_m_rad: self.stiffness_n_m_rad,
            damping_n_s_m: self.damping_n_s_m,
            damping_n_m_s_rad: self.damping_n_m_s_rad,
            rest_m: self.rest_m,
            rest_rad: self.rest_rad,
            preload_n: self.preload_n,
            preload_n_m: self.preload_n_m,
            friction_n: self.friction_n,
            friction_n_m: self.friction_n_m,
        }
    }
}
