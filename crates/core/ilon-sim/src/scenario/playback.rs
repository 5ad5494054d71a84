//! `[playback]`: the motion of a log.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::joints::Quantity;
use super::objection::Objection;

/// What a log says drives the robot: wheels, a twist or a path, from a CSV file, an MCAP file or a bag of ROS 2. Where the log also
/// says where the real robot was, that pose stands in the trace, beside that of the simulated robot.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "PlaybackSection")]
pub struct Playback {
    /// The log, relative to the scenario file: a CSV file with a column `t_s`, an MCAP file, or the folder of a bag.
    pub file: PathBuf,
    /// What of it drives the robot.
    pub drives: Drives,
    /// The topic that drives the robot; without it, the one topic of a fitting type. Of bags only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub topic: Option<String>,
    /// The topic that says where the real robot was: `nav_msgs/Odometry` or `geometry_msgs/PoseStamped`. Of bags only; a CSV file says it in
    /// `measured_x_m`, `measured_y_m` and `measured_heading_rad` or `measured_heading_deg`. These poses are placed so that the real robot
    /// starts where the simulated one does; where they begin later, so that the first is where the simulated robot is by then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose_topic: Option<String>,
    /// The topic that says what servos of joints between bodies do: `sensor_msgs/JointState`, or the positions of
    /// `trajectory_msgs/JointTrajectory`, from when it came. Of bags only; a CSV file says it in columns `JOINT_position_rad`, or `_deg`, `_m`,
    /// `_mm`; `JOINT_rate_rad_s`, or `_deg_s`, `_m_s`, `_mm_s`; and `JOINT_torque_n_m`, or `_force_n`. It drives the joints with the role `driven` that
    /// have neither a target nor setpoints in the scenario: to positions along the lines between them; rates, torques and forces hold until what is said
    /// next. An empty cell and NaN say nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_topic: Option<String>,
    /// By what of it the log drives joints between bodies; left out, each row by the first that it says: a position, a rate, a torque or force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints_by: Option<Quantity>,
    /// What the log calls otherwise: on the left a joint or a column such as `vx_m_s`, on the right the name in the log.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub names: BTreeMap<String, String>,
    /// How much of the log's beginning is left out, in seconds.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub from_s: f64,
    /// How fast wheels are led back to the log's angles, per second; 10 unless given. Of `wheel_angles` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub angle_gain_per_s: Option<f64>,
}

impl Playback {
    /// Whether the log is a CSV file.
    pub fn is_csv(&self) -> bool {
        let ending = self.file.extension();
        ending.is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
    }

    /// How fast wheels are led back to the log's angles, per second.
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
            return Err(Objection::to(
                format!("playback.{key}"),
                format!(
                    "`playback.{key}` chooses messages of a bag, but `playback.file` is a CSV file"
                ),
                "leave it out; `playback.names` says what the columns are called",
            ));
        }
        let of_wheels = [("topic", &self.topic), ("pose_topic", &self.pose_topic)];
        let topic = of_wheels.into_iter().find(|(_, topic)| topic.is_some());
        if let Some((key, _)) = topic.filter(|_| self.drives == Drives::Joints) {
            return Err(Objection::to(
                format!("playback.{key}"),
                format!(
                    "`playback.{key}` is of a log that drives the robot, but this one drives its joints alone"
                ),
                "choose their messages by `playback.joint_topic`",
            ));
        }
        if self.angle_gain_per_s.is_some() && self.drives != Drives::WheelAngles {
            return Err(Objection::to(
                "playback.angle_gain_per_s",
                "`playback.angle_gain_per_s` leads wheels back to angles, but the log does not drive them by angles",
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
    /// The rate of each wheel, in rad/s: columns `JOINT_rate_rad_s`, or the velocities of `sensor_msgs/JointState`. A rate holds until the
    /// next; before the first and after the last the wheels stand.
    WheelRates,
    /// The angle of each wheel, in radians: columns `JOINT_angle_rad`, or the positions of `sensor_msgs/JointState`. They count from the
    /// first.
    WheelAngles,
    /// The torque at each wheel, in N m: columns `JOINT_torque_n_m`, or the efforts of `sensor_msgs/JointState`. A torque holds until the
    /// next.
    WheelTorques,
    /// The twist of the body: columns `vx_m_s`, `vy_m_s` and `omega_rad_s`, or `geometry_msgs/TwistStamped`, `Twist` or `nav_msgs/Odometry`. It
    /// becomes wheel rates as that of `[twist]` does.
    Twist,
    /// Where the body was, for the guidance to track: columns `x_m`, `y_m` and `heading_rad` or `heading_deg`, or `nav_msgs/Odometry`,
    /// `geometry_msgs/PoseStamped` or `nav_msgs/Path`. The path begins where the robot starts.
    Path,
    /// Joints between bodies alone, as `joint_topic` says: beside a `[reference]` or a `[twist]`, which drives the wheels.
    Joints,
}
