//! What of a live run is a parameter, in ROS 2 and in Foxglove.
//!
//! | parameter | is |
//! |---|---|
//! | `friction` | the friction coefficient of the floor |
//! | `payload_kg` | the mass carried on top of the scenario's, kg |
//! | `position_gain_per_s`, `heading_gain_per_s` | the guidance's gains, 1/s |
//! | `mode` | `hand` or `reference` |
//! | `priority` | `position` or `heading` |
//! | `speed` | simulated seconds a second |
//! | `paused` | whether time stands |
//! | `resets` | how often the robot went back to its start; any other number sends it there |

use crate::control::{Change, Controls, Mode, Priority};
use crate::desk::Desk;
use crate::session::Session;

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Count(i64),
    Flag(bool),
    Word(String),
    /// None of these.
    Other,
}

/// The parameters of a session.
#[derive(Clone, Debug)]
pub(crate) struct Parameters {
    desk: Desk,
    /// What holds where nobody said anything.
    friction: f64,
    gains_per_s: [f64; 2],
    priority: Priority,
}

impl Parameters {
    pub fn of(session: &Session, desk: &Desk) -> Self {
        Self {
            desk: desk.clone(),
            friction: session.friction(),
            gains_per_s: session.gains_per_s(),
            priority: session.priority(),
        }
    }

    /// All of them, as they are now.
    pub fn now(&self) -> Vec<(&'static str, Value)> {
        self.all(&self.desk.controls())
    }

    /// All of them, under these controls.
    pub fn all(&self, controls: &Controls) -> Vec<(&'static str, Value)> {
        let word = |text: &str| Value::Word(text.to_owned());
        let [position, heading] = self.gains_per_s;
        let mode = match controls.mode {
            Mode::Hand => "hand",
            Mode::Reference => "reference",
        };
        let priority = match controls.priority.unwrap_or(self.priority) {
            Priority::Position => "position",
            Priority::Heading => "heading",
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
            ("priority", word(priority)),
            ("speed", Value::Number(controls.speed)),
            ("paused", Value::Flag(controls.paused)),
            (
                "resets",
                Value::Count(i64::try_from(controls.resets).unwrap_or(i64::MAX)),
            ),
        ]
    }

    /// Sets a parameter; gives what there is to say about it.
    ///
    /// # Errors
    /// Why it is not set.
    pub fn set(&self, name: &str, value: &Value) -> Result<Option<String>, String> {
        let change = self.change(name, value)?;
        Ok(self.desk.change(&change))
    }

    /// What a parameter that is set asks for.
    ///
    /// # Errors
    /// Why it asks for nothing.
    pub fn change(&self, name: &str, value: &Value) -> Result<Change, String> {
        let number = || match value {
            Value::Number(number) => Ok(Some(*number)),
            Value::Count(count) => Ok(Some(*count as f64)),
            _ => Err(format!("{name} is a number")),
        };
        let word = || match value {
            Value::Word(word) => Ok(word.as_str()),
            _ => Err(format!("{name} is a word")),
        };
        let mut change = Change::default();
        match name {
            "friction" => change.friction = number()?,
            "payload_kg" => change.payload_kg = number()?,
            "position_gain_per_s" => change.position_gain_per_s = number()?,
            "heading_gain_per_s" => change.heading_gain_per_s = number()?,
            "speed" => change.speed = number()?,
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
