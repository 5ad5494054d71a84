//! Commands to a live run, and their limits.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ilon_robot::Twist;
use ilon_sim::JointCommand;
pub use ilon_sim::scenario::Priority;
use serde::Deserialize;
use smart_default::SmartDefault;

/// A commanded twist that is not repeated within this time stops the robot.
pub const WATCHDOG: Duration = Duration::from_millis(500);

/// Limit of twist commands, independent of the wheels: m/s and rad/s.
const MOST_M_S: f64 = 20.0;
const MOST_RAD_S: f64 = 50.0;
/// Limit of wheel rate commands, in rad/s; the scenario's limit may be lower.
const MOST_WHEEL_RAD_S: f64 = 1000.0;
/// Limit of joint positions, in rad or m, and of joint rates, in rad/s or m/s; the joint's own
/// limits may be lower.
const MOST_JOINT: f64 = 1e4;
/// Limit of joint efforts, in N m or N; the joint's own may be lower.
const MOST_JOINT_EFFORT: f64 = 1e6;
/// Largest number of stored joints, so that names cannot fill the memory.
const MOST_JOINTS: usize = 256;
/// Allowed friction coefficients.
pub(crate) const FRICTIONS: std::ops::RangeInclusive<f64> = 0.0..=2.0;
/// Allowed payloads, in kg.
pub(crate) const PAYLOADS_KG: std::ops::RangeInclusive<f64> = 0.0..=1000.0;
/// Allowed speeds, in simulated seconds per second.
pub(crate) const SPEEDS: std::ops::RangeInclusive<f64> = 0.05..=20.0;
/// Limit of the force of a push, in N.
const MOST_PUSH_N: f64 = 10_000.0;
/// A push that is not repeated within this time ends.
const PUSH_LASTS: Duration = Duration::from_millis(200);
/// Allowed gains of the guidance, in 1/s.
pub(crate) const GAINS_PER_S: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// What determines the robot's motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// The commanded twist of the user.
    #[default]
    Hand,
    /// The guidance, along the scenario's reference.
    Reference,
}

/// Returns the name of a priority; "none" if none is set.
pub(crate) fn priority_in_words(priority: Option<Priority>) -> &'static str {
    match priority {
        None => "none",
        Some(Priority::Position) => "position",
        Some(Priority::Heading) => "heading",
    }
}

/// A manual command.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// A twist of the body frame's origin, in the body frame.
    Twist(Twist),
    /// A rate for each wheel, in rad/s, in the robot's order.
    Wheels(Arc<[f64]>),
}

/// The current commands and settings.
#[derive(Clone, Debug, SmartDefault)]
pub struct Controls {
    #[default(Command::Twist(Twist::default()))]
    command: Command,
    commanded: Option<Instant>,
    /// Commands of servos of joints between bodies, by the joints' names, each with its command
    /// number.
    joints: BTreeMap<String, (JointCommand, u64)>,
    /// Number of joint commands.
    joint_commands: u64,
    /// The last push, along x and y of the world in N, and when it came.
    push_n: Option<([f64; 2], Instant)>,
    /// Whether the drive is recorded.
    pub records: bool,
    /// Number of commands.
    pub commands: u64,
    /// What determines the motion.
    pub mode: Mode,
    /// Priority of the tasks; by default the scenario's.
    pub priority: Option<Priority>,
    /// Friction coefficient of the floor; by default the scenario's.
    pub friction: Option<f64>,
    /// Payload in addition to the scenario's, in kg.
    pub payload_kg: f64,
    /// Gain of the guidance's position feedback, in 1/s; by default the scenario's.
    pub position_gain_per_s: Option<f64>,
    /// Gain of the guidance's heading feedback, in 1/s; by default the scenario's.
    pub heading_gain_per_s: Option<f64>,
    /// Speed, in simulated seconds per second.
    #[default = 1.0]
    pub speed: f64,
    /// Whether time stands.
    pub paused: bool,
    /// Number of returns to the start.
    pub resets: u64,
}

/// A change; absent fields keep their value.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Change {
    /// vx, vy in m/s and omega in rad/s, in the body frame.
    pub twist: Option<[f64; 3]>,
    /// A rate for each wheel, in rad/s.
    pub wheels: Option<Vec<f64>>,
    /// Target positions of servos of joints between bodies, in rad or m, by the joints' names. They
    /// stay until the next command.
    pub joints: Option<BTreeMap<String, f64>>,
    /// Rates of these joints, in rad/s or m/s, until the next command.
    pub joint_rates: Option<BTreeMap<String, f64>>,
    /// Torques or forces of these joints, in N m or N, until the next command.
    pub joint_efforts: Option<BTreeMap<String, f64>>,
    /// A push at the chassis's centre of mass, along x and y of the world in N. It lasts for a
    /// fifth of a second, unless it is repeated.
    pub push_n: Option<[f64; 2]>,
    /// Whether the drive is recorded. A recording begins with a return to the start.
    pub record: Option<bool>,
    /// What determines the motion.
    pub mode: Option<Mode>,
    /// Priority of the tasks.
    pub priority: Option<Priority>,
    /// The friction coefficient of the floor.
    pub friction: Option<f64>,
    /// Additional payload, in kg.
    pub payload_kg: Option<f64>,
    /// Gain of the position feedback, in 1/s.
    pub position_gain_per_s: Option<f64>,
    /// Gain of the heading feedback, in 1/s.
    pub heading_gain_per_s: Option<f64>,
    /// Speed, in simulated seconds per second.
    pub speed: Option<f64>,
    /// Whether time stands.
    pub paused: Option<bool>,
    /// Whether the robot returns to its start.
    pub reset: Option<bool>,
}

impl Controls {
    /// Applies a JSON message; returns a note, if any. Values out of range are limited; an invalid
    /// message changes nothing.
    pub fn take(&mut self, text: &str) -> Option<String> {
        // A list would be read as the fields' values in order.
        if !text.trim_start().starts_with('{') {
            return Some("not understood: a message is a JSON object".to_owned());
        }
        match serde_json::from_str(text) {
            Ok(change) => self.change(&change),
            Err(error) => Some(format!("not understood: {error}")),
        }
    }

    /// Applies a change; returns a note, if any. Values out of range are limited; NaN is ignored.
    pub fn change(&mut self, change: &Change) -> Option<String> {
        let mut said = Vec::new();
        if let Some([vx, vy, omega]) = change.twist {
            let parts = [
                ("vx", vx, MOST_M_S),
                ("vy", vy, MOST_M_S),
                ("omega", omega, MOST_RAD_S),
            ];
            let taken =
                parts.map(|(name, asked, most)| limited(name, asked, -most..=most, &mut said));
            if let [Some(vx), Some(vy), Some(omega)] = taken {
                self.command(Command::Twist(Twist::new(vx, vy, omega)));
            }
        }
        if let Some(rates) = &change.wheels {
            let range = -MOST_WHEEL_RAD_S..=MOST_WHEEL_RAD_S;
            let rates: Option<Arc<[f64]>> = rates
                .iter()
                .enumerate()
                .map(|(wheel, asked)| {
                    let name = format!("the rate of wheel {wheel}");
                    limited(&name, *asked, range.clone(), &mut said)
                })
                .collect();
            if let Some(rates) = rates {
                self.command(Command::Wheels(rates));
            }
        }
        /// The values for joints, their limit, and the resulting command.
        type OfJoints<'a> = (
            &'a str,
            &'a Option<BTreeMap<String, f64>>,
            f64,
            fn(f64) -> JointCommand,
        );
        let of_joints: [OfJoints<'_>; 3] = [
            ("position", &change.joints, MOST_JOINT, |position| {
                JointCommand::Position {
                    position,
                    rate: 0.0,
                }
            }),
            ("rate", &change.joint_rates, MOST_JOINT, JointCommand::Rate),
            (
                "effort",
                &change.joint_efforts,
                MOST_JOINT_EFFORT,
                JointCommand::Effort,
            ),
        ];
        for (what, asked, most, command) in of_joints {
            for (joint, asked) in asked.iter().flatten() {
                if self.joints.len() >= MOST_JOINTS && !self.joints.contains_key(joint) {
                    said.push(format!(
                        "more than {MOST_JOINTS} joints: `{joint}` is not taken"
                    ));
                    continue;
                }
                let name = format!("the {what} of `{joint}`");
                if let Some(number) = limited(&name, *asked, -most..=most, &mut said) {
                    self.joint_commands += 1;
                    let told = (command(number), self.joint_commands);
                    self.joints.insert(joint.clone(), told);
                }
            }
        }
        let mut number = |name, asked: Option<f64>, range| limited(name, asked?, range, &mut said);
        self.friction = number("friction", change.friction, FRICTIONS).or(self.friction);
        if let Some(payload_kg) = number("payload_kg", change.payload_kg, PAYLOADS_KG) {
            self.payload_kg = payload_kg;
        }
        let gain = number(
            "position_gain_per_s",
            change.position_gain_per_s,
            GAINS_PER_S,
        );
        self.position_gain_per_s = gain.or(self.position_gain_per_s);
        let gain = number("heading_gain_per_s", change.heading_gain_per_s, GAINS_PER_S);
        self.heading_gain_per_s = gain.or(self.heading_gain_per_s);
        if let Some(speed) = number("speed", change.speed, SPEEDS) {
            self.speed = speed;
        }
        if let Some(push_n) = change.push_n {
            let range = -MOST_PUSH_N..=MOST_PUSH_N;
            let taken = push_n.map(|push_n| limited("push_n", push_n, range.clone(), &mut said));
            if let [Some(x), Some(y)] = taken {
                self.push_n = Some(([x, y], Instant::now()));
            }
        }
        self.records = change.record.unwrap_or(self.records);
        self.mode = change.mode.unwrap_or(self.mode);
        self.priority = change.priority.or(self.priority);
        self.paused = change.paused.unwrap_or(self.paused);
        self.resets += u64::from(change.reset == Some(true));
        (!said.is_empty()).then(|| said.join("; "))
    }

    fn command(&mut self, command: Command) {
        self.command = command;
        self.commanded = Some(Instant::now());
        self.commands += 1;
    }

    /// The force of the push that acts now, along x and y of the world, in N.
    pub fn push_n(&self) -> Option<[f64; 2]> {
        let acting = self
            .push_n
            .filter(|(_, since)| since.elapsed() < PUSH_LASTS);
        acting.map(|(push_n, _)| push_n)
    }

    /// The number of joint commands.
    pub fn joint_commands(&self) -> u64 {
        self.joint_commands
    }

    /// Returns the joint commands after a given number of them.
    pub fn joints_since(&self, commands: u64) -> impl Iterator<Item = (&str, JointCommand)> {
        let since = self
            .joints
            .iter()
            .filter(move |(_, (_, number))| *number > commands);
        since.map(|(joint, (told, _))| (joint.as_str(), *told))
    }

    /// Returns the last command, and its age; a twist of zero without commands.
    pub fn last_command(&self) -> (&Command, Option<Duration>) {
        (&self.command, self.commanded.map(|at| at.elapsed()))
    }
}

/// Limits a number to a range; `None` for NaN. Any deviation gives a note.
fn limited(
    name: &str,
    asked: f64,
    range: std::ops::RangeInclusive<f64>,
    said: &mut Vec<String>,
) -> Option<f64> {
    if asked.is_nan() {
        said.push(format!("{name} is no number: it is not taken"));
        return None;
    }
    let taken = asked.clamp(*range.start(), *range.end());
    if taken != asked {
        said.push(format!("{name} {asked} is out of range: {taken} is taken"));
    }
    Some(taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn twist(controls: &Controls) -> Twist {
        match controls.last_command().0 {
            Command::Twist(twist) => *twist,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_command_out_of_range_is_limited_and_said() {
        let mut controls = Controls::default();
        assert_eq!(controls.take(r#"{"twist": [0.5, -0.2, 1.0]}"#), None);
        assert_eq!(twist(&controls), Twist::new(0.5, -0.2, 1.0));
        let said = controls
            .take(r#"{"twist": [1e9, 0, 0], "friction": -3}"#)
            .unwrap();
        assert!(
            said.contains("vx 1000000000 is out of range: 20 is taken"),
            "{said}"
        );
        assert!(said.contains("friction -3"), "{said}");
        assert_eq!(twist(&controls), Twist::new(20.0, 0.0, 0.0));
        assert_eq!(controls.friction, Some(0.0));
    }

    /// Each joint's last command counts once, whatever commands other joints received since.
    #[test]
    fn joints_are_sent_where_they_were_last_told() {
        let mut controls = Controls::default();
        assert_eq!(
            controls.take(r#"{"joints": {"arm": 0.5, "lift": 0.1}}"#),
            None
        );
        let heard = controls.joint_commands();
        assert_eq!(controls.joints_since(heard).next(), None);
        assert_eq!(controls.take(r#"{"joints": {"arm": 0.5}}"#), None);
        let since: Vec<_> = controls.joints_since(heard).collect();
        let arm = JointCommand::Position {
            position: 0.5,
            rate: 0.0,
        };
        assert_eq!(since, [("arm", arm)]);
        let heard = controls.joint_commands();
        controls.take(r#"{"joint_rates": {"arm": 0.2}, "joint_efforts": {"lift": -3}}"#);
        let since: Vec<_> = controls.joints_since(heard).collect();
        let told = [
            ("arm", JointCommand::Rate(0.2)),
            ("lift", JointCommand::Effort(-3.0)),
        ];
        assert_eq!(since, told);
        let heard = controls.joint_commands();
        let said = controls.change(&Change {
            joints: Some([("arm".to_owned(), f64::NAN)].into()),
            ..Change::default()
        });
        assert!(said.expect("it is said").contains("`arm`"));
        assert_eq!(controls.joint_commands(), heard);
    }

    #[test]
    fn what_is_no_message_changes_nothing() {
        let mut controls = Controls::default();
        controls.take(r#"{"twist": [0.5, 0, 0], "speed": 2}"#);
        for text in [
            "",
            "{",
            "[]",
            "{\"twist\": [NaN, 0, 0]}",
            "{\"twist\": [1e999, 0, 0]}",
            "{\"twist\": [1]}",
            "{\"other\": 1}",
            "{\"mode\": \"fly\"}",
        ] {
            assert!(controls.take(text).is_some(), "{text}");
            assert_eq!(twist(&controls), Twist::new(0.5, 0.0, 0.0), "{text}");
            assert_eq!(controls.speed, 2.0);
        }
    }

    #[test]
    fn what_is_no_number_is_not_taken() {
        let mut controls = Controls::default();
        controls.take(r#"{"twist": [0.5, 0, 0], "friction": 0.4}"#);
        let said = controls.change(&Change {
            twist: Some([0.1, f64::NAN, 0.0]),
            wheels: Some(vec![1.0, f64::NAN]),
            friction: Some(f64::NAN),
            speed: Some(f64::INFINITY),
            ..Change::default()
        });
        let said = said.expect("something is said");
        for part in ["vy", "wheel 1", "friction", "speed inf is out of range"] {
            assert!(said.contains(part), "{said}");
        }
        assert_eq!(twist(&controls), Twist::new(0.5, 0.0, 0.0));
        assert_eq!((controls.friction, controls.commands), (Some(0.4), 1));
        assert_eq!(controls.speed, 20.0);
    }
}
