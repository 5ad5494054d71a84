//! Logs as bags of ROS 2 and MCAP files.

use ilon_files::FileAccess;
use ilon_messages::Message;
use ilon_messages::bag::{self, ReadMessage, Seen};
use ilon_messages::geometry_msgs::{PoseStamped, Twist, TwistStamped};
use ilon_messages::nav_msgs::{Odometry, Path};
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::std_msgs::Float64MultiArray;
use ilon_messages::trajectory_msgs::JointTrajectory;

use super::joint_log::QUANTITIES;
use super::series::Series;
use super::wanted::{LogContents, Wanted};
use crate::Error;
use crate::foreign::MOST_ROWS;
use crate::scenario::Drives;

/// Reads the motion of robot and joints, and the real robot's poses. Times are those of the
/// recording.
pub(super) fn read(wanted: &Wanted<'_>, files: &FileAccess) -> Result<LogContents, Error> {
    if let Drives::WheelRates | Drives::WheelAngles | Drives::WheelTorques = wanted.section.drives {
        wanted.all_wheels.iter().for_each(|wheel| {
            wanted.name(wheel);
        });
    }
    wanted.joints.iter().for_each(|(joint, _)| {
        wanted.name(joint);
    });
    wanted.refuse_unused_names()?;
    let drives_joints_alone = wanted.section.drives == Drives::Joints;
    let topic = match (&wanted.section.topic, &wanted.section.joint_topic) {
        (Some(topic), _) => Some(topic.clone()),
        (None, Some(_)) if drives_joints_alone => None,
        (None, _) => Some(only_topic(wanted, files)?),
    };
    let (topic, joint_topic) = match drives_joints_alone {
        true => (None, wanted.section.joint_topic.clone().or(topic)),
        false => (topic, wanted.section.joint_topic.clone()),
    };
    let width = match wanted.section.drives {
        Drives::Twist | Drives::Path => 3,
        _ => wanted.wheels.len(),
    };
    let mut joints = vec![Series::new(QUANTITIES.len()); wanted.joints.len()];
    let pose_topic = wanted.section.pose_topic.as_deref();
    let (mut driving, mut measured) = (Series::new(width), pose_topic.map(|_| Series::new(3)));
    let mut fault = None;
    let mut seen = Seen::default();
    let is_whole = read_all(wanted, files, &mut |message| {
        let t_s = seen.note(message);
        let said = Said {
            wanted,
            message,
            t_s,
        };
        let mut take = || -> Result<(), Error> {
            if Some(message.topic) == topic.as_deref() {
                said.drive(&mut driving)?;
            }
            if Some(message.topic) == joint_topic.as_deref() {
                said.move_joints(&mut joints)?;
            }
            if let Some(measured) = measured
                .as_mut()
                .filter(|_| Some(message.topic) == pose_topic)
            {
                let poses = said.poses()?;
                let [x, y, heading] = poses.last().map_or([f64::NAN; 3], |(_, pose)| *pose);
                measured.push(t_s, said.finite(vec![x, y, heading])?);
            }
            Ok(())
        };
        fault = take().err();
        let longest = joints.iter().map(Series::len).max().unwrap_or(0);
        if driving.len().max(longest) > MOST_ROWS {
            let message = format!(
                "it has more than {MOST_ROWS} messages of `{}`",
                message.topic
            );
            fault = Some(wanted.fault(message, "cut it into parts"));
        }
        fault.is_none()
    })?;
    if let Some(fault) = fault {
        return Err(fault);
    }
    for (key, topic) in [
        ("topic", topic.as_deref()),
        ("pose_topic", pose_topic),
        ("joint_topic", joint_topic.as_deref()),
    ] {
        if let Some(topic) = topic.filter(|topic| !seen.topics().contains_key(*topic)) {
            return Err(wanted.fault(
                format!("it has no messages of `playback.{key}` = `{topic}`"),
                format!("its topics are {}", seen.listed()),
            ));
        }
    }
    Ok(LogContents {
        driving,
        measured,
        joints,
        is_whole,
    })
}

fn read_all(
    wanted: &Wanted<'_>,
    files: &FileAccess,
    see: &mut dyn FnMut(&ReadMessage) -> bool,
) -> Result<bool, Error> {
    bag::read(wanted.path, files, see).map_err(|fault| {
        wanted.fault(
            fault.to_string(),
            "name a CSV file, an MCAP file, or the folder of a bag with MCAP files",
        )
    })
}

/// The message types that can provide the data, the most likely first.
fn types(drives: Drives) -> &'static [&'static str] {
    match drives {
        Drives::WheelRates => &[JointState::TYPE_NAME, Float64MultiArray::TYPE_NAME],
        Drives::WheelAngles | Drives::WheelTorques => &[JointState::TYPE_NAME],
        Drives::Joints => &[JointState::TYPE_NAME, JointTrajectory::TYPE_NAME],
        Drives::Twist => &[
            TwistStamped::TYPE_NAME,
            Twist::TYPE_NAME,
            Odometry::TYPE_NAME,
        ],
        Drives::Path => &[Odometry::TYPE_NAME, PoseStamped::TYPE_NAME, Path::TYPE_NAME],
    }
}

/// The only topic whose messages can provide the data.
fn only_topic(wanted: &Wanted<'_>, files: &FileAccess) -> Result<String, Error> {
    let mut seen = Seen::default();
    read_all(wanted, files, &mut |message| {
        seen.note(message);
        true
    })?;
    let fitting = |kind: &&str| -> Vec<&String> {
        let of_kind = seen.topics().iter().filter(|(_, known)| known == kind);
        of_kind.map(|(topic, _)| topic).collect()
    };
    let fits: Vec<&String> = types(wanted.section.drives)
        .iter()
        .flat_map(fitting)
        .collect();
    match fits[..] {
        [only] => Ok(only.clone()),
        [] => Err(wanted.fault(
            format!(
                "none of its topics is of the type {}",
                types(wanted.section.drives).join(" or ")
            ),
            format!("its topics are {}", seen.listed()),
        )),
        _ => {
            let names: Vec<String> = fits.iter().map(|topic| format!("`{topic}`")).collect();
            Err(wanted.fault(
                format!(
                    "several of its topics could drive the robot: {}",
                    names.join(", ")
                ),
                match wanted.section.drives {
                    Drives::Joints => "choose one with `playback.joint_topic`",
                    _ => "choose one with `playback.topic`",
                },
            ))
        }
    }
}

/// A message, and its time since the first of all, in seconds.
struct Said<'a> {
    wanted: &'a Wanted<'a>,
    message: &'a ReadMessage<'a>,
    t_s: f64,
}

impl Said<'_> {
    /// Adds the joint data of a message. It may name some of the joints, and others that are
    /// irrelevant.
    fn move_joints(&self, joints: &mut [Series]) -> Result<(), Error> {
        if self.message.type_name == JointTrajectory::TYPE_NAME {
            return self.follow_trajectory(joints);
        }
        let state: JointState = self.decode_of(Drives::Joints)?;
        let said = [
            (&state.position, "positions"),
            (&state.velocity, "velocities"),
            (&state.effort, "efforts"),
        ];
        let names = state.name.len();
        let is_odd = |numbers: &Vec<f64>| !numbers.is_empty() && numbers.len() != names;
        if let Some((numbers, what)) = said.iter().find(|(numbers, _)| is_odd(numbers)) {
            return Err(self.fault(
                &format!("has {names} names and {} {what}", numbers.len()),
                format!("give each joint that it names one of the {what}, or none at all"),
            ));
        }
        for ((joint, _), series) in self.wanted.joints.iter().zip(joints) {
            let theirs = self.wanted.name(joint);
            let Some(place) = state.name.iter().position(|name| name == theirs) else {
                continue;
            };
            let row = said.map(|(numbers, _)| numbers.get(place).copied().unwrap_or(f64::NAN));
            let known = row.iter().copied().filter(|number| !number.is_nan());
            if !self.finite(known.collect())?.is_empty() {
                series.push(self.t_s, row);
            }
        }
        Ok(())
    }

    /// Adds a trajectory from the time of its message: it replaces the rest of an earlier one, and
    /// starts from the position reached.
    fn follow_trajectory(&self, joints: &mut [Series]) -> Result<(), Error> {
        let trajectory = self.decode::<JointTrajectory>()?;
        let names = &trajectory.joint_names;
        for ((joint, _), series) in self.wanted.joints.iter().zip(joints) {
            let theirs = self.wanted.name(joint);
            let Some(place) = names.iter().position(|name| name == theirs) else {
                continue;
            };
            series.cut(self.t_s);
            for point in &trajectory.points {
                if point.positions.len() != names.len() {
                    let (names, positions) = (names.len(), point.positions.len());
                    return Err(self.fault(
                        &format!("has {names} names and a point of {positions} positions"),
                        "give each joint that it names a position in each point",
                    ));
                }
                let after_s = &point.time_from_start;
                let at_s = self.t_s + f64::from(after_s.sec) + 1e-9 * f64::from(after_s.nanosec);
                // A point at time zero is the current target.
                if series.times_s.last().is_some_and(|last_s| *last_s == at_s) {
                    series.pop();
                }
                let position = self.finite(vec![point.positions[place]])?;
                series.push(at_s, [position[0], f64::NAN, f64::NAN]);
            }
        }
        Ok(())
    }

    /// Adds the motion of a message.
    fn drive(&self, driving: &mut Series) -> Result<(), Error> {
        let values = match self.wanted.section.drives {
            Drives::Joints => return Ok(()),
            Drives::WheelRates if self.message.type_name == Float64MultiArray::TYPE_NAME => {
                self.numbers_of_wheels()?
            }
            Drives::WheelRates | Drives::WheelAngles | Drives::WheelTorques => {
                match self.joints_of_wheels()? {
                    Some(values) => values,
                    None => return Ok(()),
                }
            }
            Drives::Twist => {
                let twist = match self.message.type_name {
                    name if name == Twist::TYPE_NAME => self.decode::<Twist>()?,
                    name if name == Odometry::TYPE_NAME => self.decode::<Odometry>()?.twist.twist,
                    _ => self.decode::<TwistStamped>()?.twist,
                };
                vec![twist.linear.x, twist.linear.y, twist.angular.z]
            }
            Drives::Path => {
                for (within_s, pose) in self.poses()? {
                    driving.push(self.t_s + within_s, self.finite(pose.to_vec())?);
                }
                return Ok(());
            }
        };
        driving.push(self.t_s, self.finite(values)?);
        Ok(())
    }

    /// One number of each wheel, in the robot's order.
    fn numbers_of_wheels(&self) -> Result<Vec<f64>, Error> {
        let data = self.decode::<Float64MultiArray>()?.data;
        let (numbers, wheels) = (data.len(), self.wanted.all_wheels.len());
        if numbers == wheels {
            let driven = self.wanted.wheels.iter();
            return Ok(driven.map(|(wheel, _)| data[*wheel]).collect());
        }
        if numbers == self.wanted.wheels.len() {
            return Ok(data);
        }
        let topic = self.message.topic;
        Err(self.wanted.fault(
            format!("a message of `{topic}` has {numbers} numbers, but the robot {wheels} wheels"),
            "drive it by messages with the names of joints, `sensor_msgs/JointState`",
        ))
    }

    /// One number of each wheel by its name; `None` of a message about other joints of the robot,
    /// such as an arm's.
    fn joints_of_wheels(&self) -> Result<Option<Vec<f64>>, Error> {
        let (wanted, joints) = (self.wanted, self.decode::<JointState>()?);
        let (values, what) = match wanted.section.drives {
            Drives::WheelRates => (&joints.velocity, "velocity"),
            Drives::WheelAngles => (&joints.position, "position"),
            _ => (&joints.effort, "effort"),
        };
        let mut names = wanted.wheels.iter().map(|(_, wheel)| wanted.name(wheel));
        if values.is_empty() || !names.any(|wheel| joints.name.iter().any(|name| name == wheel)) {
            return Ok(None);
        }
        let of_wheel = |(_, wheel): &(usize, &str)| {
            let name = wanted.name(wheel);
            let place = joints.name.iter().position(|known| known == name);
            let value = place.and_then(|place| values.get(place)).copied();
            value.ok_or_else(|| {
                let named = joints.name.iter().take(20);
                let named: Vec<String> = named.map(|name| format!("`{name}`")).collect();
                let (topic, named) = (self.message.topic, named.join(", "));
                wanted.fault(
                    format!("`{topic}` has no {what} of the wheel `{name}`"),
                    format!("its joints are {named}: `playback.names.{wheel}` says which it is"),
                )
            })
        };
        wanted
            .wheels
            .iter()
            .map(of_wheel)
            .collect::<Result<_, _>>()
            .map(Some)
    }

    /// The poses of a message, x, y and heading, each with its time after the first in seconds.
    fn poses(&self) -> Result<Vec<(f64, [f64; 3])>, Error> {
        if self.message.type_name == Odometry::TYPE_NAME {
            let odometry = self.decode::<Odometry>()?;
            return Ok(vec![(0.0, odometry.pose.pose.planar())]);
        }
        if self.message.type_name == Path::TYPE_NAME {
            let path = self.decode::<Path>()?;
            let times: Vec<f64> = path
                .poses
                .iter()
                .map(|pose| {
                    let stamp = pose.header.stamp;
                    f64::from(stamp.sec) + f64::from(stamp.nanosec) * 1e-9
                })
                .collect();
            if times.windows(2).any(|pair| pair[1] <= pair[0]) {
                return Err(self.wanted.fault(
                    format!("the poses of the path on `{}` have no increasing times", self.message.topic),
                    "write its points into a CSV file, and drive along them by `[reference.waypoints]` with a speed",
                ));
            }
            let poses = path.poses.iter().zip(&times);
            return Ok(poses
                .map(|(pose, t_s)| (t_s - times[0], pose.pose.planar()))
                .collect());
        }
        let stamped = self.decode::<PoseStamped>()?;
        Ok(vec![(0.0, stamped.pose.planar())])
    }

    /// Decodes a message that drives the robot.
    fn decode<M: Message>(&self) -> Result<M, Error> {
        self.decode_of(self.wanted.section.drives)
    }

    /// Decodes a message, naming the accepted types in an error.
    fn decode_of<M: Message>(&self, drives: Drives) -> Result<M, Error> {
        let choose = || format!("choose a topic of the type {}", types(drives).join(" or "));
        let decoded = self.message.decode();
        decoded.map_err(|fault| self.wanted.fault(fault.to_string(), fault.help(choose)))
    }

    fn finite(&self, values: Vec<f64>) -> Result<Vec<f64>, Error> {
        let is_computable = |value: &f64| value.is_finite() && value.abs() <= 1e9;
        match values.iter().all(is_computable) {
            true => Ok(values),
            false => Err(self.fault(
                "holds a number that is not finite or too large",
                "leave it out of the recording",
            )),
        }
    }

    /// A fault of the message, and how to repair it.
    fn fault(&self, what: &str, help: impl Into<String>) -> Error {
        let (topic, t_s) = (self.message.topic, self.t_s);
        let message = format!("a message of `{topic}`, {t_s:.3} s after the first of all, {what}");
        self.wanted.fault(message, help)
    }
}
