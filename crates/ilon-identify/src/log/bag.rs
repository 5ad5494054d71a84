//! Logs as bags of ROS 2 and MCAP files.

use std::collections::BTreeMap;
use std::path::Path;

use ilon_files::FileAccess;
use ilon_messages::bag::{self, ReadMessage};
use ilon_messages::geometry_msgs::PoseStamped;
use ilon_messages::nav_msgs::Odometry;
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::{CdrError, Message};
use ilon_robot::Robot;
use ilon_sim::Error;
use ilon_sim::foreign::MOST_ROWS;

use super::format::Format;
use super::series::Log;

/// Wheel angles as they were recorded, and the pose at those times on the line between the poses around them.
pub(super) fn read(
    path: &Path,
    format: &Format,
    robot: &Robot,
    files: &FileAccess,
) -> Result<Log, Error> {
    let Some(topics) = &format.bag else {
        return Err(Error::contents(
            path,
            "it is read as a bag, of which the study names no topics",
            "write `[log.bag]` with `joints` and `pose`; a table's name ends in .csv, .tsv, .txt or .dat",
        ));
    };
    let names: Vec<&str> = robot
        .wheels
        .iter()
        .map(|wheel| {
            topics
                .names
                .get(&wheel.name)
                .unwrap_or(&wheel.name)
                .as_str()
        })
        .collect();
    let mut log = Log::default();
    let mut poses: Vec<(f64, [f64; 3])> = Vec::new();
    let mut seen: BTreeMap<String, String> = BTreeMap::new();
    let mut first_ns = None;
    let mut failed = None;
    let mut take = |message: &ReadMessage| -> Result<(), Error> {
        let since_ns = *first_ns.get_or_insert(message.log_time_ns);
        let t_s = (i128::from(message.log_time_ns) - i128::from(since_ns)) as f64 * 1e-9;
        if !seen.contains_key(message.topic) && seen.len() < 1000 {
            seen.insert(message.topic.to_owned(), message.type_name.to_owned());
        }
        if message.topic == topics.joints {
            let joints: JointState = decode(path, message)?;
            if !joints
                .name
                .iter()
                .any(|name| names.contains(&name.as_str()))
            {
                return Ok(());
            }
            let angle = |name: &&str| {
                let place = joints.name.iter().position(|known| known == name);
                let angle = place.and_then(|place| joints.position.get(place)).copied();
                angle.filter(|angle| angle.is_finite()).ok_or_else(|| {
                    Error::contents(
                        path,
                        format!("`{}` has no angle of `{name}` at {t_s:.3} s", message.topic),
                        "record positions of all wheels; `log.bag.names` says what a wheel is called in the bag",
                    )
                })
            };
            let angles: Result<Vec<f64>, Error> = names.iter().map(angle).collect();
            log.times_s.push(t_s);
            log.angles_rad.push(angles?);
        } else if message.topic == topics.pose {
            let pose = match message.type_name {
                name if name == Odometry::TYPE_NAME => decode::<Odometry>(path, message)?.pose.pose,
                name if name == PoseStamped::TYPE_NAME => {
                    decode::<PoseStamped>(path, message)?.pose
                }
                other => {
                    return Err(Error::contents(
                        path,
                        format!("`{}` is of the type {other}", message.topic),
                        "name a topic of nav_msgs/Odometry or geometry_msgs/PoseStamped in `log.bag.pose`",
                    ));
                }
            };
            poses.push((t_s, pose.planar()));
        }
        if log.times_s.len() > MOST_ROWS || poses.len() > MOST_ROWS {
            let message = format!("it has more than {MOST_ROWS} messages of one topic");
            return Err(Error::contents(path, message, "cut it into parts"));
        }
        Ok(())
    };
    bag::read(path, files, &mut |message| {
        failed = take(message).err();
        failed.is_none()
    })
    .map_err(|reason| {
        Error::contents(
            path,
            reason.to_string(),
            "name a table, an MCAP file, or the folder of a bag with MCAP files",
        )
    })?;
    if let Some(failed) = failed {
        return Err(failed);
    }
    for (key, topic, count) in [
        ("joints", &topics.joints, log.times_s.len()),
        ("pose", &topics.pose, poses.len()),
    ] {
        if count == 0 {
            let listed: Vec<String> = seen
                .iter()
                .map(|(topic, kind)| format!("`{topic}` ({kind})"))
                .collect();
            return Err(Error::contents(
                path,
                format!("it has nothing of the robot on `log.bag.{key}` = `{topic}`"),
                format!("its topics are {}", listed.join(", ")),
            ));
        }
    }
    if let Some(at) = poses.windows(2).position(|pair| pair[1].0 <= pair[0].0) {
        return Err(Error::contents(
            path,
            format!(
                "the times of `{}` do not grow at {} s",
                topics.pose, poses[at].0
            ),
            "order its messages by time, and leave each once",
        ));
    }
    log.poses = log
        .times_s
        .iter()
        .map(|t_s| between(&poses, *t_s))
        .collect();
    Ok(log)
}

/// The pose on the line between its neighbours, their headings the short way round; nothing beyond them.
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
    if message.type_name != M::TYPE_NAME {
        return Err(Error::contents(
            path,
            format!("`{}` is of the type {}", message.topic, message.type_name),
            format!("name a topic of the type {}", M::TYPE_NAME),
        ));
    }
    M::decode(message.cdr).map_err(|reason: CdrError| {
        Error::contents(
            path,
            format!(
                "a message of `{}` is no {}: {reason}",
                message.topic,
                M::TYPE_NAME
            ),
            "the recording is damaged, or its type has other fields than that of ROS 2",
        )
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// From (0, 4) to (2, 0) in two seconds, and over the back: from 0.1 rad short of half a turn to 0.3 rad beyond it.
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
