//! `[playback]`: motion from a log.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checks::objection::{Objection, objection};
use super::joints::Quantity;

/// Drives the robot by a log: a CSV file, an MCAP file or a ROS 2 bag. If the log has the real
/// robot's pose, the trace has it beside the simulated one.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "PlaybackSection")]
pub struct Playback {
    /// The log, relative to the scenario: a CSV file with a column `t_s`, an MCAP file, or a bag's
    /// folder.
    pub file: PathBuf,
    /// What drives the robot.
    pub drives: Drives,
    /// Bags: topic that drives the robot [default: the only fitting one].
    pub topic: Option<String>,
    /// Bags: topic of the real robot's pose, `nav_msgs/Odometry` or `geometry_msgs/PoseStamped`. A
    /// CSV file uses `measured_x_m`, `measured_y_m` and `measured_heading_rad` or `_deg`. Poses are
    /// shifted so that the first is where the simulated robot is.
    pub pose_topic: Option<String>,
    /// Bags: the topic that drives joints with the role `driven` without a target or setpoints:
    /// `sensor_msgs/JointState` or `trajectory_msgs/JointTrajectory`. A CSV file uses columns
    /// `JOINT_position_rad` (`_deg`, `_m`, `_mm`), `JOINT_rate_rad_s` (`_deg_s`, `_m_s`, `_mm_s`),
    /// `JOINT_torque_n_m` or `JOINT_force_n`.
    pub joint_topic: Option<String>,
    /// Which values of the log drive joints [default: per row the first of position, rate, torque
    /// or force].
    pub joints_by: Option<Quantity>,
    /// Other names in the log: `OURS = "THEIRS"`, for joints and columns such as `vx_m_s`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub names: BTreeMap<String, String>,
    /// Skipped beginning of the log, in seconds.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub from_s: f64,
    /// Gain that leads wheels back to the log's angles, in 1/s; 10 unless given. For
    /// `wheel_angles`.
    #[schemars(range(min = 0.0))]
    pub angle_gain_per_s: Option<f64>,
}

impl Playback {
    /// Whether the log is a CSV file.
    pub fn is_csv(&self) -> bool {
        let ending = self.file.extension();
        ending.is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
    }

    /// Gain that leads wheels back to the log's angles, in 1/s; 10 unless given. For
    /// `wheel_angles`.
    pub fn angle_gain_per_s(&self) -> f64 {
        self.angle_gain_per_s.unwrap_or(10.0)
    }

    /// Refuses keys that would be ignored.
    pub(super) fn object(&self) -> Result<(), Objection> {
        let of_bags = [
            ("topic", &self.topic),
            ("pose_topic", &self.pose_topic),
            ("joint_topic", &self.joint_topic),
        ];
        let topic = of_bags.into_iter().find(|(_, topic)| topic.is_some());
        if let Some((key, _)) = topic.filter(|_| self.is_csv()) {
            return Err(objection!(
                "playback.{key}",
                "`playback.{key}` chooses messages of a bag, but `playback.file` is a CSV file",
                "leave it out; `playback.names` says what the columns are called",
            ));
        }
        let of_wheels = [("topic", &self.topic), ("pose_topic", &self.pose_topic)];
        let topic = of_wheels.into_iter().find(|(_, topic)| topic.is_some());
        if let Some((key, _)) = topic.filter(|_| self.drives == Drives::Joints) {
            return Err(objection!(
                "playback.{key}",
                "`playback.{key}` is for a log that drives the wheels, but this one only drives joints between bodies",
                "choose their messages by `playback.joint_topic`",
            ));
        }
        if self.angle_gain_per_s.is_some() && self.drives != Drives::WheelAngles {
            return Err(objection!(
                "playback.angle_gain_per_s",
                "`playback.angle_gain_per_s` has no effect: the log does not drive the wheels by their angles",
                "leave it out, or write `playback.drives` = \"wheel_angles\"",
            ));
        }
        Ok(())
    }
}

/// What of a log drives the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Drives {
    /// The rate of each wheel, in rad/s: columns `JOINT_rate_rad_s`, or the velocities of
    /// `sensor_msgs/JointState`. A rate holds until the next; before the first and after the last
    /// the wheels stand.
    WheelRates,
    /// The angle of each wheel, in radians: columns `JOINT_angle_rad`, or the positions of
    /// `sensor_msgs/JointState`. They count from the first.
    WheelAngles,
    /// The torque at each wheel, in N m: columns `JOINT_torque_n_m`, or the efforts of
    /// `sensor_msgs/JointState`. A torque holds until the next.
    WheelTorques,
    /// The twist of the body: columns `vx_m_s`, `vy_m_s` and `omega_rad_s`, or
    /// `geometry_msgs/TwistStamped`, `Twist` or `nav_msgs/Odometry`. It becomes wheel rates as that
    /// of `[twist]` does.
    Twist,
    /// Where the body was, for the guidance to track: columns `x_m`, `y_m` and `heading_rad` or
    /// `heading_deg`, or `nav_msgs/Odometry`, `geometry_msgs/PoseStamped` or `nav_msgs/Path`. The
    /// path begins where the robot starts.
    Path,
    /// Joints between bodies alone, as `joint_topic` says: beside a `[reference]` or a `[twist]`,
    /// which drives the wheels.
    Joints,
}
