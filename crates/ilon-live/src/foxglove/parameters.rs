//! What of a live run is a parameter.

use std::sync::{Mutex, PoisonError};

use foxglove::websocket::{
    AnyClient, GetParametersResponder, Parameter, ParameterHandler, ParameterValue,
    SetParametersResponder,
};

use crate::control::{Change, Controls, Mode, Priority};
use crate::desk::Desk;
use crate::session::Session;

/// What holds where nobody said anything.
#[derive(Clone, Copy, Debug)]
pub(super) struct Defaults {
    friction: f64,
    gains_per_s: [f64; 2],
    priority: Priority,
}

impl Defaults {
    pub fn of(session: &Session) -> Self {
        Self {
            friction: session.friction(),
            gains_per_s: session.gains_per_s(),
            priority: session.priority(),
        }
    }
}

/// The parameters, and what was shown of them last.
#[derive(Debug)]
pub(super) struct Parameters {
    desk: Desk,
    defaults: Defaults,
    shown: Mutex<Vec<Parameter>>,
}

impl Parameters {
    pub fn new(desk: Desk, defaults: Defaults) -> Self {
        Self {
            desk,
            defaults,
            shown: Mutex::default(),
        }
    }

    /// All of them.
    fn all(&self, controls: &Controls) -> Vec<Parameter> {
        let [position, heading] = self.defaults.gains_per_s;
        let flag = |name: &str, value| Parameter {
            name: name.to_owned(),
            r#type: None,
            value: Some(ParameterValue::Bool(value)),
        };
        let mode = match controls.mode {
            Mode::Hand => "hand",
            Mode::Reference => "reference",
        };
        let priority = match controls.priority.unwrap_or(self.defaults.priority) {
            Priority::Position => "position",
            Priority::Heading => "heading",
        };
        vec![
            Parameter::float64(
                "friction",
                controls.friction.unwrap_or(self.defaults.friction),
            ),
            Parameter::float64("payload_kg", controls.payload_kg),
            Parameter::float64(
                "position_gain_per_s",
                controls.position_gain_per_s.unwrap_or(position),
            ),
            Parameter::float64(
                "heading_gain_per_s",
                controls.heading_gain_per_s.unwrap_or(heading),
            ),
            Parameter::string("mode", mode),
            Parameter::string("priority", priority),
            Parameter::float64("speed", controls.speed),
            flag("paused", controls.paused),
            Parameter::integer("resets", i64::try_from(controls.resets).unwrap_or(i64::MAX)),
        ]
    }

    fn some(&self, names: &[String]) -> Vec<Parameter> {
        let mut all = self.all(&self.desk.controls());
        // No names are all names.
        all.retain(|parameter| names.is_empty() || names.contains(&parameter.name));
        all
    }

    /// Those that have changed since the last time.
    pub fn changed(&self, controls: &Controls) -> Vec<Parameter> {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        let all = self.all(controls);
        let changed = all.iter().filter(|now| !shown.contains(now)).cloned();
        let changed = changed.collect();
        *shown = all;
        changed
    }

    /// What a parameter that is set asks for, or why it asks for nothing.
    fn change(&self, parameter: &Parameter) -> Result<Change, String> {
        let name = parameter.name.as_str();
        let number = || match parameter.value {
            Some(ParameterValue::Float64(value)) => Ok(Some(value)),
            Some(ParameterValue::Integer(value)) => Ok(Some(value as f64)),
            _ => Err(format!("{name} is a number")),
        };
        let word = || match &parameter.value {
            Some(ParameterValue::String(value)) => Ok(value.as_str()),
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
            "paused" => match parameter.value {
                Some(ParameterValue::Bool(paused)) => change.paused = Some(paused),
                _ => return Err("paused is true or false".to_owned()),
            },
            "resets" => change.reset = Some(number()? != Some(self.desk.controls().resets as f64)),
            other => return Err(format!("there is no parameter {other}")),
        }
        Ok(change)
    }
}

impl ParameterHandler for Parameters {
    fn get(
        &self,
        _client: AnyClient,
        names: Vec<String>,
        _request_id: Option<String>,
        responder: GetParametersResponder,
    ) {
        responder.respond(self.some(&names));
    }

    fn set(
        &self,
        _client: AnyClient,
        parameters: Vec<Parameter>,
        _request_id: Option<String>,
        responder: SetParametersResponder,
    ) {
        for parameter in &parameters {
            let said = match self.change(parameter) {
                Ok(change) => self.desk.change(&change),
                Err(why) => Some(format!("a parameter is not set: {why}")),
            };
            if let Some(note) = said {
                self.desk.say(note);
            }
        }
        // What they are now, which need not be what was asked for.
        let names: Vec<String> = parameters
            .into_iter()
            .map(|parameter| parameter.name)
            .collect();
        responder.respond(self.some(&names));
    }
}
