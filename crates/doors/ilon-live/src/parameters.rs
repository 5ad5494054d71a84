//! The parameters of a live run, in ROS 2 and in Foxglove.
//!
//! | parameter | meaning |
//! |---|---|
//! | `friction` | the friction coefficient of the floor |
//! | `payload_kg` | the mass carried in addition to the scenario's, kg |
//! | `position_gain_per_s`, `heading_gain_per_s` | the guidance's gains, 1/s |
//! | `mode` | `hand` or `reference` |
//! | `priority` | `position`, `heading`, or `none` where the scenario sets none: to a reference the position comes first, by hand both are scaled alike |
//! | `speed` | simulated seconds per second |
//! | `paused` | whether time stands |
//! | `resets` | number of returns to the start; setting any other number causes one |

use std::ops::RangeInclusive;

use crate::clock::Pace;
use crate::control::{
    Change, Controls, FRICTIONS, GAINS_PER_S, Mode, PAYLOADS_KG, Priority, priority_in_words,
};
use crate::mailbox::Mailbox;
use crate::session::Session;

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Count(i64),
    Flag(bool),
    Word(String),
    /// Any other type.
    Other,
}

/// The parameters of a session.
#[derive(Clone, Debug)]
pub(crate) struct Parameters {
    desk: Mailbox,
    /// The default.
    friction: f64,
    gains_per_s: [f64; 2],
    priority: Option<Priority>,
}

impl Parameters {
    pub fn of(session: &Session, desk: &Mailbox) -> Self {
        Self {
            desk: desk.clone(),
            friction: session.friction(),
            gains_per_s: session.gains_per_s(),
            priority: session.priority(),
        }
    }

    /// Returns all parameters with their current values.
    pub fn now(&self) -> Vec<(&'static str, Value)> {
        self.all(&self.desk.controls())
    }

    /// Returns all parameters under these controls.
    pub fn all(&self, controls: &Controls) -> Vec<(&'static str, Value)> {
        let word = |text: &str| Value::Word(text.to_owned());
        let [position, heading] = self.gains_per_s;
        let mode = match controls.mode {
            Mode::Hand => "hand",
            Mode::Reference => "reference",
        };
        let number = |said: Option<f64>, default| Value::Number(said.unwrap_or(default));
        vec![
            ("friction", number(controls.friction, self.friction)),
            ("payload_kg", Value::Number(controls.payload_kg)),
            (
                "position_gain_per_s",
                number(controls.position_gain_per_s, position),
            ),
            (
                "heading_gain_per_s",
                number(controls.heading_gain_per_s, heading),
            ),
            ("mode", word(mode)),
            (
                "priority",
                word(priority_in_words(controls.priority.or(self.priority))),
            ),
            ("speed", Value::Number(controls.speed)),
            ("paused", Value::Flag(controls.paused)),
            (
                "resets",
                Value::Count(i64::try_from(controls.resets).unwrap_or(i64::MAX)),
            ),
        ]
    }

    /// Sets a parameter; returns a note, if any.
    ///
    /// # Errors
    /// The reason why it is not set.
    pub fn set(&self, name: &str, value: &Value) -> Result<Option<String>, String> {
        let change = self.change(name, value)?;
        Ok(self.desk.change(&change))
    }

    /// Returns the change for a parameter's new value.
    ///
    /// # Errors
    /// The reason why the value is invalid.
    pub fn change(&self, name: &str, value: &Value) -> Result<Change, String> {
        let number = || match value {
            Value::Number(number) => Ok(Some(*number)),
            Value::Count(count) => Ok(Some(*count as f64)),
            _ => Err(format!("{name} is a number")),
        };
        // A value out of range is rejected instead of limited, because setting a parameter returns
        // whether it holds.
        let within = |range: RangeInclusive<f64>| match number()? {
            Some(asked) if !range.contains(&asked) => Err(format!(
                "{name} is from {} to {}, not {asked}",
                range.start(),
                range.end()
            )),
            asked => Ok(asked),
        };
        let word = || match value {
            Value::Word(word) => Ok(word.as_str()),
            _ => Err(format!("{name} is a word")),
        };
        let mut change = Change::default();
        match name {
            "friction" => change.friction = within(FRICTIONS)?,
            "payload_kg" => change.payload_kg = within(PAYLOADS_KG)?,
            "position_gain_per_s" => change.position_gain_per_s = within(GAINS_PER_S)?,
            "heading_gain_per_s" => change.heading_gain_per_s = within(GAINS_PER_S)?,
            "speed" => change.speed = within(Pace::SPEEDS)?,
            "mode" => {
                change.mode = Some(match word()? {
                    "hand" => Mode::Hand,
                    "reference" => Mode::Reference,
                    other => return Err(format!("mode is hand or reference, not {other}")),
                });
            }
            "priority" => {
                change.priority = Some(match word()? {
                    "position" => Priority::Position,
                    "heading" => Priority::Heading,
                    other => return Err(format!("priority is position or heading, not {other}")),
                });
            }
            "paused" => match value {
                Value::Flag(paused) => change.paused = Some(*paused),
                _ => return Err("paused is true or false".to_owned()),
            },
            "resets" => change.reset = Some(number()? != Some(self.desk.controls().resets as f64)),
            other => return Err(format!("there is no parameter {other}")),
        }
        Ok(change)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters(desk: &Mailbox) -> Parameters {
        Parameters {
            desk: desk.clone(),
            friction: 0.6,
            gains_per_s: [1.0, 1.0],
            priority: None,
        }
    }

    #[test]
    fn a_value_out_of_range_is_refused_and_changes_nothing() {
        let desk = Mailbox::default();
        let parameters = parameters(&desk);
        let before = parameters.now();
        assert!(before.contains(&("priority", Value::Word("none".to_owned()))));
        for (name, value, range) in [
            ("friction", -1.0, "from 0 to 2"),
            ("friction", 2.5, "from 0 to 2"),
            ("friction", f64::NAN, "from 0 to 2"),
            ("payload_kg", -0.1, "from 0 to 1000"),
            ("position_gain_per_s", 0.0, "from 0.01 to 100"),
            ("heading_gain_per_s", f64::INFINITY, "from 0.01 to 100"),
            ("speed", 1e9, "from "),
        ] {
            let refused = parameters.set(name, &Value::Number(value));
            let why = refused.expect_err("it is out of range");
            assert!(why.contains(name) && why.contains(range), "{why}");
        }
        assert_eq!(parameters.now(), before);
        // Both ends are valid.
        for friction in [0.0, 2.0] {
            assert_eq!(
                parameters.set("friction", &Value::Number(friction)),
                Ok(None)
            );
            assert_eq!(desk.controls().friction, Some(friction));
        }
    }
}
