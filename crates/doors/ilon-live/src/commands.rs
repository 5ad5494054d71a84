//! Converts ROS 2 messages to commands, for DDS and sockets.

use ilon_messages::geometry_msgs::{Twist, TwistStamped};
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::std_msgs::Float64MultiArray;

use crate::control::{Change, WATCHDOG};
use crate::mailbox::Mailbox;

/// Stamps further ahead of the simulated time belong to another clock, in seconds.
const AHEAD_S: f64 = 1.0;

/// Result of a message: a change, if any, and a note.
#[derive(Clone, Debug, Default)]
pub(crate) struct Received {
    pub change: Option<Change>,
    pub note: Option<String>,
}

impl Received {
    fn of(change: Change) -> Self {
        Self {
            change: Some(change),
            note: None,
        }
    }

    pub fn refused(note: String) -> Self {
        Self {
            change: None,
            note: Some(note),
        }
    }

    /// Puts the change into the mailbox; returns the note.
    pub fn taken(self, desk: &Mailbox) -> Option<String> {
        let said = self.change.and_then(|change| desk.change(&change));
        said.or(self.note)
    }
}

/// Properties of the commanded robot.
#[derive(Clone, Debug)]
pub(crate) struct Commanded {
    /// Names of its wheels' joints, in order.
    pub wheels: Vec<String>,
    /// Names of the joints between bodies with servos.
    pub joints: Vec<String>,
}

impl Commanded {
    pub fn of(robot: &ilon_robot::Robot) -> Self {
        let wheels = robot.wheels.iter().map(|wheel| wheel.name.clone());
        let driven = robot.joints.iter().filter(|joint| joint.servo().is_some());
        Self {
            wheels: wheels.collect(),
            joints: driven.map(|joint| joint.name.clone()).collect(),
        }
    }
}

/// Converts a twist, interpreted in the robot's own frame whatever frame it names.
pub(crate) fn twist(message: &Twist) -> Received {
    let Twist { linear, angular } = message;
    let idle = [linear.z, angular.x, angular.y];
    Received {
        change: Some(Change {
            twist: Some([linear.x, linear.y, angular.z]),
            ..Change::default()
        }),
        note: idle
            .iter()
            .any(|part| *part != 0.0)
            .then(|| "of a commanded twist only linear.x, linear.y and angular.z count".to_owned()),
    }
}

/// Converts a stamped twist, at a simulated time in seconds. One older than the watchdog's timeout
/// is ignored; a stamp of zero, or of another clock than the simulated one, is not checked.
pub(crate) fn twist_stamped(message: &TwistStamped, now_s: f64) -> Received {
    let stamp = message.header.stamp;
    let stamp_s = f64::from(stamp.sec) + 1e-9 * f64::from(stamp.nanosec);
    let age_s = now_s - stamp_s;
    if stamp_s > 0.0 && age_s > WATCHDOG.as_secs_f64() {
        return Received::refused(format!(
            "a command on /cmd_vel is not taken: its stamp is {age_s:.1} s old"
        ));
    }
    let mut heard = twist(&message.twist);
    if stamp_s > 0.0 && age_s < -AHEAD_S {
        heard.note = heard.note.or(Some(
            "commands on /cmd_vel have stamps of another clock, so that old ones are not noticed: set use_sim_time in the node that sends them"
                .to_owned(),
        ));
    }
    heard
}

/// Converts wheel rates by name. Wheels without a name in the message, or with a NaN rate, stand:
/// this is how a controller commands nothing.
pub(crate) fn joint_state(message: &JointState, robot: &Commanded) -> Received {
    let (names, rates) = (&message.name, &message.velocity);
    if names.len() != rates.len() {
        return Received::refused(format!(
            "a command on /robot_joint_commands is not taken: it has {} names and {} velocities; give the wheels' joints a velocity command interface, and no other joint beside them",
            names.len(),
            rates.len()
        ));
    }
    let rate_of = |wheel: &String| {
        let place = names.iter().position(|name| name == wheel)?;
        Some(rates[place])
    };
    let found: Vec<Option<f64>> = robot.wheels.iter().map(rate_of).collect();
    if found.iter().all(Option::is_none) {
        return Received::refused(format!(
            "a command on /robot_joint_commands is not taken: it names no wheel of the robot, which are {}",
            robot.wheels.join(", ")
        ));
    }
    let named = || robot.wheels.iter().zip(&found);
    let lacking = named().find(|(_, rate)| rate.is_none());
    let wild = named().find(|(_, rate)| rate.is_some_and(f64::is_nan));
    let note = lacking
        .map(|(wheel, _)| {
            format!("commands on /robot_joint_commands do not name {wheel}: it stands")
        })
        .or(wild.map(|(wheel, _)| format!("{wheel} is commanded NaN: it stands")));
    let rates = found
        .into_iter()
        .map(|rate| rate.filter(|rate| !rate.is_nan()).unwrap_or(0.0));
    let change = Change {
        wheels: Some(rates.collect()),
        ..Change::default()
    };
    Received {
        note,
        ..Received::of(change)
    }
}

/// Converts positions for joints between bodies, by name; without positions rates, and without
/// those efforts. Other joints keep their commands.
pub(crate) fn joint_commands(message: &JointState, robot: &Commanded) -> Received {
    let names = &message.name;
    let all = [&message.position, &message.velocity, &message.effort];
    let said = all.iter().position(|numbers| !numbers.is_empty());
    let numbers = said.map_or(&message.position, |said| all[said]);
    if names.len() != numbers.len() {
        let what = ["positions", "velocities", "efforts"][said.unwrap_or(0)];
        return Received::refused(format!(
            "a command on /joint_commands is not taken: it has {} names and {} {what}; give each joint that it names a position, in rad or m, or each a velocity, \
             or each an effort",
            names.len(),
            numbers.len()
        ));
    }
    let is_known = |name: &String| robot.joints.contains(name);
    if let Some(unknown) = names.iter().find(|name| !is_known(name)) {
        let known = match robot.joints.is_empty() {
            true => "it has none: give one the role `driven` in [robot.joints.NAME]".to_owned(),
            false => format!("they are {}", robot.joints.join(", ")),
        };
        return Received::refused(format!(
            "a command on /joint_commands is not taken: `{unknown}` is no joint of the robot that a servo drives; {known}"
        ));
    }
    let joints = names.iter().cloned().zip(numbers.iter().copied());
    let joints = Some(joints.collect());
    let mut change = Change::default();
    match said {
        Some(1) => change.joint_rates = joints,
        Some(2) => change.joint_efforts = joints,
        _ => change.joints = joints,
    }
    Received::of(change)
}

/// Converts rates for all wheels, in the robot's order.
pub(crate) fn rates(message: &Float64MultiArray, robot: &Commanded) -> Received {
    let skipped = message.layout.data_offset as usize;
    let data = message.data.get(skipped..).unwrap_or_default();
    if data.len() != robot.wheels.len() {
        return Received::refused(format!(
            "a command on /wheel_commands is not taken: it has {} numbers for the {} wheels {}",
            data.len(),
            robot.wheels.len(),
            robot.wheels.join(", ")
        ));
    }
    Received::of(Change {
        wheels: Some(data.to_vec()),
        ..Change::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot() -> Commanded {
        Commanded {
            wheels: ["left", "right"].map(str::to_owned).to_vec(),
            joints: vec!["arm".to_owned()],
        }
    }

    fn joints(names: &[&str], velocity: &[f64]) -> JointState {
        JointState {
            name: names.iter().map(ToString::to_string).collect(),
            velocity: velocity.to_vec(),
            ..JointState::default()
        }
    }

    #[test]
    fn wheels_are_found_by_name_in_any_order() {
        let heard = joint_state(
            &joints(&["arm", "right", "left"], &[9.0, 2.0, 1.0]),
            &robot(),
        );
        assert_eq!(heard.change.expect("taken").wheels, Some(vec![1.0, 2.0]));
        assert_eq!(heard.note, None);
    }

    #[test]
    fn a_wheel_that_is_commanded_nothing_stands_and_that_is_said() {
        for (message, wheel) in [
            (joints(&["left"], &[1.0]), "right"),
            (joints(&["left", "right"], &[1.0, f64::NAN]), "right"),
        ] {
            let heard = joint_state(&message, &robot());
            assert_eq!(heard.change.expect("taken").wheels, Some(vec![1.0, 0.0]));
            assert!(heard.note.expect("said").contains(wheel));
        }
    }

    #[test]
    fn what_names_no_wheel_or_does_not_line_up_is_not_taken() {
        for message in [
            joints(&[], &[]),
            joints(&["arm"], &[1.0]),
            joints(&["left", "right"], &[1.0]),
            joints(&["left", "right"], &[]),
        ] {
            let heard = joint_state(&message, &robot());
            assert!(
                heard.change.is_none() && heard.note.is_some(),
                "{message:?}"
            );
        }
        for data in [vec![], vec![1.0], vec![1.0, 2.0, 3.0]] {
            let message = Float64MultiArray {
                data,
                ..Float64MultiArray::default()
            };
            assert!(rates(&message, &robot()).change.is_none());
        }
        let mut message = Float64MultiArray {
            data: vec![9.0, 1.0, 2.0],
            ..Float64MultiArray::default()
        };
        message.layout.data_offset = 1;
        let heard = rates(&message, &robot());
        assert_eq!(heard.change.expect("taken").wheels, Some(vec![1.0, 2.0]));
        message.layout.data_offset = u32::MAX;
        assert!(rates(&message, &robot()).change.is_none());
    }

    #[test]
    fn joints_between_bodies_go_by_name_and_what_names_another_is_not_taken() {
        let at = |names: &[&str], position: &[f64]| {
            let message = JointState {
                position: position.to_vec(),
                ..joints(names, &[])
            };
            joint_commands(&message, &robot())
        };
        let sent = at(&["arm"], &[0.3]).change.expect("taken").joints;
        assert_eq!(sent, Some([("arm".to_owned(), 0.3)].into()));
        let run = joint_commands(&joints(&["arm"], &[0.2]), &robot());
        let rates = run.change.expect("taken").joint_rates;
        assert_eq!(rates, Some([("arm".to_owned(), 0.2)].into()));
        let loaded = JointState {
            effort: vec![3.0],
            ..joints(&["arm"], &[])
        };
        let loaded = joint_commands(&loaded, &robot()).change.expect("taken");
        assert_eq!(loaded.joint_efforts, Some([("arm".to_owned(), 3.0)].into()));
        assert_eq!(loaded.joints, None);
        for (names, positions, words) in [
            (&["arn"][..], &[0.3][..], "`arn` is no joint"),
            (&["arm", "left"], &[0.3, 0.1], "`left` is no joint"),
            (&["arm"], &[], "1 names and 0 positions"),
            (&["arm"], &[0.1, 0.2], "1 names and 2 positions"),
        ] {
            let heard = at(names, positions);
            assert!(heard.change.is_none());
            let note = heard.note.expect("said");
            assert!(note.contains(words), "{note}");
        }
    }

    #[test]
    fn an_old_stamp_is_refused_and_one_of_another_clock_is_said() {
        let at = |sec, nanosec| {
            let mut message = TwistStamped::default();
            message.header.stamp.sec = sec;
            message.header.stamp.nanosec = nanosec;
            message.twist.linear.x = 0.3;
            message
        };
        // No stamp, a fresh one, one of half a second ago.
        for message in [at(0, 0), at(100, 0), at(99, 600_000_000)] {
            let heard = twist_stamped(&message, 100.0);
            assert_eq!(heard.change.expect("taken").twist, Some([0.3, 0.0, 0.0]));
            assert_eq!(heard.note, None);
        }
        let old = twist_stamped(&at(99, 0), 100.0);
        assert!(old.change.is_none() && old.note.expect("said").contains("1.0 s old"));
        let wall = twist_stamped(&at(1_790_000_000, 0), 100.0);
        assert!(wall.change.is_some() && wall.note.expect("said").contains("use_sim_time"));
    }
}
