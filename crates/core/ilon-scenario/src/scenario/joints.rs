//! `[robot.joints.NAME]`: joints other than those of wheels and rollers.

use ilon_formats::{JointOptions, RoleOption};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checks::objection::{Objection, object_if};

/// A joint other than wheels and rollers. Keys with `rad` or `n_m` are for joints that turn, the
/// others for joints that slide.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(rename = "RobotJointSection")]
pub struct Joint {
    /// What the robot's file is read with.
    #[serde(flatten)]
    pub options: JointOptions,
    /// What the servo does over time. Before the first setpoint it holds the first, after the last
    /// the last.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub setpoints: Vec<JointSetpoint>,
    /// How the target goes from one setpoint to the next.
    #[serde(skip_serializing_if = "Between::is_smooth")]
    pub between: Between,
}

/// A time with one of: position, rate, torque or force. All setpoints of a joint are of one kind.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "RobotJointSetpoint")]
pub struct JointSetpoint {
    /// Time since the start, in seconds.
    #[schemars(range(min = 0.0))]
    pub t_s: f64,
    /// Position, in metres.
    pub position_m: Option<f64>,
    /// Position, in radians.
    pub position_rad: Option<f64>,
    /// Rate at which the target moves on from where the joint is, in m/s.
    pub rate_m_s: Option<f64>,
    /// Rate at which the target moves on from where the joint is, in rad/s.
    pub rate_rad_s: Option<f64>,
    /// Force on the body, within the servo's effort, in N. Nothing holds a position.
    pub force_n: Option<f64>,
    /// Torque on the body, within the servo's effort, in N m. Nothing holds a position.
    pub torque_n_m: Option<f64>,
}

/// What is commanded of a servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "RobotJointQuantity")]
pub enum Quantity {
    /// Where to take its joint, in rad or m.
    Position,
    /// How fast to move it, in rad/s or m/s.
    Rate,
    /// With what torque or force to act, in N m or N.
    Effort,
}

impl JointSetpoint {
    /// All that it may say: what it is of, whether of a joint that turns, its key, and its number.
    pub fn values(&self) -> [(Quantity, bool, &'static str, Option<f64>); 6] {
        [
            (Quantity::Position, false, "position_m", self.position_m),
            (Quantity::Position, true, "position_rad", self.position_rad),
            (Quantity::Rate, false, "rate_m_s", self.rate_m_s),
            (Quantity::Rate, true, "rate_rad_s", self.rate_rad_s),
            (Quantity::Effort, false, "force_n", self.force_n),
            (Quantity::Effort, true, "torque_n_m", self.torque_n_m),
        ]
    }

    /// The keys that it has.
    fn keys(&self) -> Vec<&'static str> {
        let values = self.values().into_iter();
        values
            .filter_map(|(_, _, key, value)| value.map(|_| key))
            .collect()
    }
}

/// How a target, a rate, a torque or a force goes from one setpoint to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "RobotJointBetween")]
pub enum Between {
    /// From rest to rest with the least jerk: 10 s^3 - 15 s^4 + 6 s^5 of the way at a share s of
    /// the time.
    #[default]
    Smooth,
    /// At a constant rate, as between the points of a recorded motion.
    Linear,
}

impl Between {
    fn is_smooth(&self) -> bool {
        *self == Self::Smooth
    }

    /// The greatest rate on the way from one setpoint to the next, over the mean rate.
    pub fn peak(self) -> f64 {
        match self {
            Self::Smooth => 15.0 / 8.0,
            Self::Linear => 1.0,
        }
    }
}

impl Joint {
    /// The options for reading the robot's file.
    pub(super) fn options(&self) -> JointOptions {
        // A run begins at the first setpoint.
        let first = self.setpoints.first();
        JointOptions {
            target_m: self.options.target_m.or(first.and_then(|of| of.position_m)),
            target_rad: self
                .options
                .target_rad
                .or(first.and_then(|of| of.position_rad)),
            ..self.options.clone()
        }
    }

    /// The fault of its setpoints, and how to repair it.
    pub(super) fn object(&self, name: &str) -> Result<(), Objection> {
        if self.setpoints.is_empty() {
            return Ok(());
        }
        object_if!(
            self.options.role != Some(RoleOption::Driven),
            "robot.joints.{name}.setpoints",
            "the joint `{name}` has setpoints but no servo to follow them",
            "write role = \"driven\" for it, or leave the setpoints out",
        );
        object_if!(
            self.options.target().is_some(),
            "robot.joints.{name}.setpoints",
            "the joint `{name}` has both setpoints and a target",
            "leave one of the two out",
        );
        let mut before_s = f64::NEG_INFINITY;
        for (index, point) in self.setpoints.iter().enumerate() {
            let at = format!("robot.joints.{name}.setpoints.{index}");
            let t_s = point.t_s;
            let values = point.values().into_iter().filter_map(|(.., value)| value);
            let mut values = values.chain([t_s]);
            object_if!(
                !values.all(f64::is_finite) || t_s < 0.0,
                "{at}",
                "a setpoint of the joint `{name}` is not finite, or its time is before the start",
                "give a time of 0 s or more and a finite number",
            );
            object_if!(
                t_s <= before_s,
                "{at}",
                "the setpoints of the joint `{name}` are not in order of time: one at {t_s} s comes after one at {before_s} s",
                "sort them by time, each later than the one before",
            );
            before_s = t_s;
            let keys = point.keys();
            object_if!(
                keys.len() != 1 || keys != self.setpoints[0].keys(),
                "{at}",
                "each setpoint of the joint `{name}` must have exactly one of position, rate, and torque or force, the same one in all of them",
                "write one of `position_rad`, `rate_rad_s` and `torque_n_m` in each where the joint turns, of `position_m`, `rate_m_s` and `force_n` where it \
                 slides",
            );
        }
        Ok(())
    }
}
