//! What a page may say, and within which limits it counts.

use std::time::{Duration, Instant};

use ilon_robot::Twist;
use serde::Deserialize;

/// A commanded twist that is not repeated for as long stops the robot.
pub const WATCHDOG: Duration = Duration::from_millis(500);

/// The largest commands that are taken, whatever the wheels can do: m/s and rad/s.
const MOST_M_S: f64 = 20.0;
const MOST_RAD_S: f64 = 50.0;
/// How fast time may go.
const PACES: std::ops::RangeInclusive<f64> = 0.05..=20.0;
/// Friction coefficients that are taken.
const FRICTIONS: std::ops::RangeInclusive<f64> = 0.0..=2.0;

/// Who decides where the robot goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// The person: the commanded twist.
    #[default]
    Hand,
    /// The guidance, along the reference of the scenario.
    Reference,
}

/// Which task of the guidance comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Priority {
    /// Position before heading.
    Position,
    /// Heading before position.
    Heading,
}

/// What was said last.
#[derive(Clone, Debug)]
pub struct Controls {
    twist: Twist,
    commanded: Option<Instant>,
    /// Who decides.
    pub mode: Mode,
    /// Which task comes first; as the scenario has it where nothing was said.
    pub priority: Option<Priority>,
    /// The friction coefficient of the floor; as the scenario has it where nothing was said.
    pub friction: Option<f64>,
    /// How fast time goes, in simulated seconds a second.
    pub speed: f64,
    /// Whether time stands.
    pub paused: bool,
    /// How often the robot was put back to its start.
    pub resets: u64,
}

impl Default for Controls {
    fn default() -> Self {
        Self {
            twist: Twist::default(),
            commanded: None,
            mode: Mode::default(),
            priority: None,
            friction: None,
            speed: 1.0,
            paused: false,
            resets: 0,
        }
    }
}

/// A message of a page. What it does not name stays as it is.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Message {
    /// vx, vy in m/s and omega in rad/s, in the body frame.
    twist: Option<[f64; 3]>,
    mode: Option<Mode>,
    priority: Option<Priority>,
    friction: Option<f64>,
    speed: Option<f64>,
    paused: Option<bool>,
    reset: Option<bool>,
}

impl Controls {
    /// Takes a message, as JSON; gives what there is to say about it. What is out of range is limited, and what is no message changes
    /// nothing.
    pub fn take(&mut self, text: &str) -> Option<String> {
        // A list would be taken for the values of the fields in their order.
        if !text.trim_start().starts_with('{') {
            return Some("not understood: a message is a JSON object".to_owned());
        }
        let message: Message = match serde_json::from_str(text) {
            Ok(message) => message,
            Err(error) => return Some(format!("not understood: {error}")),
        };
        let mut said = Vec::new();
        let mut limited = |name: &str, asked: f64, range: std::ops::RangeInclusive<f64>| {
            let taken = if asked.is_finite() {
                asked.clamp(*range.start(), *range.end())
            } else {
                asked.max(*range.start()).min(*range.end())
            };
            if taken != asked {
                said.push(format!("{name} {asked} is out of range: {taken} is taken"));
            }
            taken
        };
        if let Some([vx, vy, omega]) = message.twist {
            self.twist = Twist::new(
                limited("vx", vx, -MOST_M_S..=MOST_M_S),
                limited("vy", vy, -MOST_M_S..=MOST_M_S),
                limited("omega", omega, -MOST_RAD_S..=MOST_RAD_S),
            );
            self.commanded = Some(Instant::now());
        }
        if let Some(friction) = message.friction {
            self.friction = Some(limited("friction", friction, FRICTIONS));
        }
        if let Some(speed) = message.speed {
            self.speed = limited("speed", speed, PACES);
        }
        self.mode = message.mode.unwrap_or(self.mode);
        self.priority = message.priority.or(self.priority);
        self.paused = message.paused.unwrap_or(self.paused);
        self.resets += u64::from(message.reset == Some(true));
        (!said.is_empty()).then(|| said.join("; "))
    }

    /// The commanded twist: none where it was not repeated for [`WATCHDOG`].
    pub fn twist(&self) -> Twist {
        match self.commanded {
            Some(at) if at.elapsed() < WATCHDOG => self.twist,
            _ => Twist::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_out_of_range_is_limited_and_said() {
        let mut controls = Controls::default();
        assert_eq!(controls.take(r#"{"twist": [0.5, -0.2, 1.0]}"#), None);
        assert_eq!(controls.twist(), Twist::new(0.5, -0.2, 1.0));
        let said = controls
            .take(r#"{"twist": [1e9, 0, 0], "friction": -3}"#)
            .unwrap();
        assert!(
            said.contains("vx 1000000000 is out of range: 20 is taken"),
            "{said}"
        );
        assert!(said.contains("friction -3"), "{said}");
        assert_eq!(controls.twist(), Twist::new(20.0, 0.0, 0.0));
        assert_eq!(controls.friction, Some(0.0));
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
            assert_eq!(controls.twist(), Twist::new(0.5, 0.0, 0.0), "{text}");
            assert_eq!(controls.speed, 2.0);
        }
    }

    #[test]
    fn a_command_that_is_not_repeated_stops_the_robot() {
        let mut controls = Controls::default();
        assert_eq!(controls.twist(), Twist::default());
        controls.take(r#"{"twist": [0.5, 0, 0]}"#);
        controls.commanded = Some(Instant::now() - WATCHDOG);
        assert_eq!(controls.twist(), Twist::default());
    }
}
