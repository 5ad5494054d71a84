//! Reads logs from ROS 2 bags and MCAP files.

use std::path::Path;

use ilon_files::FileAccess;
use ilon_messages::Message;
use ilon_messages::bag::{self, ReadMessage, Seen};
use ilon_messages::geometry_msgs::{Pose, PoseStamped};
use ilon_messages::nav_msgs::Odometry;
use ilon_messages::sensor_msgs::JointState;
use ilon_robot::Robot;
use ilon_sim::Error;
use ilon_sim::foreign::MOST_ROWS;

use super::format::{Bag, Format};
use super::series::Log;
use crate::steered::{needs_column, steering_joints};

/// Reads wheel angles as recorded, and interpolates the poses linearly at their times.
pub(super) fn read(
    path: &Path,
    format: &Format,
    robot: &Robot,
    files: &FileAccess,
) -> Result<Log, Error> {
    let Some(topics) = &format.bag else {
        return Err(Error::contents(
            path,
            "it is read as a bag, but the study names no topics",
            "write `[log.bag]` with `joints` and `pose`; a table's name ends in .csv, .tsv, .txt or .dat",
        ));
    };
    let mut recorded = Recorded::new(path, topics, robot);
    let mut failed = None;
    let is_whole = bag::read(path, files, &mut |message| {
        failed = recorded.take(message).err();
        failed.is_none()
    })
    .map_err(|reason| {
        Error::contents(
            path,
            reason.to_string(),
            "name a table, an MCAP file, or the folder of a bag with MCAP files",
        )
    })?;
    recorded.log.is_cut_short = !is_whole;
    match failed {
        Some(failed) => Err(failed),
        None => recorded.into_log(),
    }
}

/// The recorded data of a robot while messages arrive.
struct Recorded<'a> {
    path: &'a Path,
    topics: &'a Bag,
    robot: &'a Robot,
    /// The robot's wheels by their indices, and their names in the bag.
    wheels: Vec<(usize, &'a str)>,
    /// The same of the joints that steer them.
    steering: Vec<(usize, &'a str)>,
    log: Log,
    poses: Vec<(f64, [f64; 3])>,
    seen: Seen,
}

impl<'a> Recorded<'a> {
    fn new(path: &'a Path, topics: &'a Bag, robot: &'a Robot) -> Self {
        let named = |name: &'a String| topics.names.get(name).unwrap_or(name).as_str();
        let wheels = robot.wheels.iter().enumerate();
        let steering = steering_joints(robot).into_iter();
        Self {
            path,
            topics,
            robot,
            wheels: wheels
                .filter(|(_, wheel)| needs_column(robot, wheel))
                .map(|(at, wheel)| (at, named(&wheel.name)))
                .collect(),
            steering: steering
                .map(|at| (at, named(&robot.joints[at].name)))
                .collect(),
            log: Log::default(),
            poses: Vec::new(),
            seen: Seen::default(),
        }
    }

    fn wrong(&self, message: impl Into<String>, help: impl Into<String>) -> Error {
        Error::contents(self.path, message, help)
    }

    fn take(&mut self, message: &ReadMessage) -> Result<(), Error> {
        let t_s = self.seen.note(message);
        if message.topic == self.topics.joints {
            self.take_joints(t_s, &decode(self.path, message)?)?;
        } else if message.topic == self.topics.pose {
            let pose = self.pose(message)?;
            self.poses.push((t_s, pose.planar()));
        }
        if self.log.times_s.len() > MOST_ROWS || self.poses.len() > MOST_ROWS {
            let message = format!("it has more than {MOST_ROWS} messages of one topic");
            return Err(self.wrong(message, "cut it into parts"));
        }
        Ok(())
    }

    /// Takes the angles of all wheels; ignores messages about other joints.
    fn take_joints(&mut self, t_s: f64, joints: &JointState) -> Result<(), Error> {
        let is_wheel = |name: &String| self.wheels.iter().any(|(_, wheel)| wheel == name);
        if !joints.name.iter().any(is_wheel) {
            return Ok(());
        }
        let angle = |name: &str| {
            let place = joints.name.iter().position(|known| known == name);
            let angle = place.and_then(|place| joints.position.get(place)).copied();
            angle.filter(|angle| angle.is_finite()).ok_or_else(|| {
                self.wrong(
                    format!("`{}` has no angle of `{name}` at {t_s:.3} s", self.topics.joints),
                    "record positions of all wheels and of what steers them; `log.bag.names` says what a joint is called in the bag",
                )
            })
        };
        let all = |named: &[(usize, &str)], count: usize| {
            let mut angles = vec![0.0; count];
            for (at, name) in named {
                angles[*at] = angle(name)?;
            }
            Ok::<_, Error>(angles)
        };
        let angles = all(&self.wheels, self.robot.wheels.len())?;
        if !self.steering.is_empty() {
            let mut positions = all(&self.steering, self.robot.joints.len())?;
            self.robot.couple(&mut positions);
            self.log.steering_rad.push(positions);
        }
        self.log.times_s.push(t_s);
        self.log.angles_rad.push(angles);
        Ok(())
    }

    fn pose(&self, message: &ReadMessage) -> Result<Pose, Error> {
        match message.type_name {
            name if name == Odometry::TYPE_NAME => {
                Ok(decode::<Odometry>(self.path, message)?.pose.pose)
            }
            name if name == PoseStamped::TYPE_NAME => {
                Ok(decode::<PoseStamped>(self.path, message)?.pose)
            }
            other => Err(self.wrong(
                format!("`{}` is of the type {other}", message.topic),
                "name a topic of nav_msgs/Odometry or geometry_msgs/PoseStamped in `log.bag.pose`",
            )),
        }
    }

    /// Builds the log after all messages: interpolates the pose at each of its times.
    fn into_log(mut self) -> Result<Log, Error> {
        for (key, topic, count) in [
            ("joints", &self.topics.joints, self.log.times_s.len()),
            ("pose", &self.topics.pose, self.poses.len()),
        ] {
            if count == 0 {
                return Err(self.wrong(
                    format!("it has nothing of the robot on `log.bag.{key}` = `{topic}`"),
                    format!("its topics are {}", self.seen.listed()),
                ));
            }
        }
        let mut pairs = self.poses.windows(2);
        if let Some(at) = pairs.position(|pair| pair[1].0 <= pair[0].0) {
            return Err(self.wrong(
                format!(
                    "the times of `{}` do not increase at {} s",
                    self.topics.pose, self.poses[at].0
                ),
                "sort its messages by time, and keep each once",
            ));
        }
        let times = self.log.times_s.iter();
        self.log.poses = times.map(|t_s| between(&self.poses, *t_s)).collect();
        Ok(self.log)
    }
}

/// Interpolates the pose between its neighbours, headings by the shorter way; NaN beyond them.
fn between(poses: &[(f64, [f64; 3])], t_s: f64) -> [f64; 3] {
    let after = poses.partition_point(|(time_s, _)| *time_s <= t_s);
    let (Some((from_s, from)), to) = (
        after.checked_sub(1).and_then(|before| poses.get(before)),
        poses.get(after),
    ) else {
        return [f64::NAN; 3];
    };
    let Some((to_s, to)) = to else {
        return if *from_s == t_s { *from } else { [f64::NAN; 3] };
    };
    let share = (t_s - from_s) / (to_s - from_s);
    let turn = ilon_robot::wrap_angle(to[2] - from[2]);
    [
        from[0] + share * (to[0] - from[0]),
        from[1] + share * (to[1] - from[1]),
        from[2] + share * turn,
    ]
}

fn decode<M: Message>(path: &Path, message: &ReadMessage) -> Result<M, Error> {
    let choose = || format!("name a topic of the type {}", M::TYPE_NAME);
    let decoded = message.decode();
    decoded.map_err(|fault| Error::contents(path, fault.to_string(), fault.help(choose)))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// From (0, 4) to (2, 0) in two seconds, with the heading across pi: from 0.1 rad short of half
    /// a turn to 0.3 rad beyond it.
    #[test]
    fn a_pose_between_two_lies_on_the_line_and_turns_the_short_way() {
        let poses = [(1.0, [0.0, 4.0, PI - 0.1]), (3.0, [2.0, 0.0, 0.3 - PI])];
        let [x, y, heading] = between(&poses, 1.5);
        assert!((x - 0.5).abs() < 1e-15 && (y - 3.0).abs() < 1e-15);
        // A quarter of 0.4 rad further.
        assert!(
            ilon_robot::wrap_angle(heading - PI).abs() < 1e-15,
            "{heading}"
        );
        assert_eq!(between(&poses, 1.0), poses[0].1);
        assert_eq!(between(&poses, 3.0), poses[1].1);
        assert!(between(&poses, 0.9)[0].is_nan() && between(&poses, 3.1)[0].is_nan());
    }
}
