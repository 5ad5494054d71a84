//! The parameters of a live run in Foxglove.

use std::sync::Mutex;

use foxglove::websocket::{
    AnyClient, GetParametersResponder, Parameter, ParameterHandler, ParameterValue,
    SetParametersResponder,
};

use crate::control::Controls;
use crate::mailbox::{Mailbox, locked};
use crate::parameters::{Parameters, Value};

/// The parameters, with the values shown last.
#[derive(Debug)]
pub(super) struct Panel {
    desk: Mailbox,
    parameters: Parameters,
    shown: Mutex<Vec<(&'static str, Value)>>,
}

impl Panel {
    pub fn new(desk: Mailbox, parameters: Parameters) -> Self {
        Self {
            desk,
            parameters,
            shown: Mutex::default(),
        }
    }

    /// Returns the parameters with these names; all for no names.
    fn named(&self, names: &[String]) -> Vec<Parameter> {
        let mut all = self.parameters.now();
        all.retain(|(name, _)| names.is_empty() || names.iter().any(|wanted| wanted == name));
        all.into_iter().map(parameter).collect()
    }

    /// Returns the parameters that changed since the last call.
    pub fn changed(&self, controls: &Controls) -> Vec<Parameter> {
        let mut shown = locked(&self.shown);
        let all = self.parameters.all(controls);
        let changed = all.iter().filter(|now| !shown.contains(now)).cloned();
        let changed = changed.map(parameter).collect();
        *shown = all;
        changed
    }
}

fn parameter((name, value): (&'static str, Value)) -> Parameter {
    match value {
        Value::Number(number) => Parameter::float64(name, number),
        Value::Count(count) => Parameter::integer(name, count),
        Value::Word(word) => Parameter::string(name, word),
        Value::Flag(flag) => Parameter {
            name: name.to_owned(),
            r#type: None,
            value: Some(ParameterValue::Bool(flag)),
        },
        Value::Other => Parameter::empty(name),
    }
}

fn value(of: &Parameter) -> Value {
    match &of.value {
        Some(ParameterValue::Float64(number)) => Value::Number(*number),
        Some(ParameterValue::Integer(count)) => Value::Count(*count),
        Some(ParameterValue::Bool(flag)) => Value::Flag(*flag),
        Some(ParameterValue::String(word)) => Value::Word(word.clone()),
        _ => Value::Other,
    }
}

impl ParameterHandler for Panel {
    fn get(
        &self,
        _client: AnyClient,
        names: Vec<String>,
        _request_id: Option<String>,
        responder: GetParametersResponder,
    ) {
        responder.respond(self.named(&names));
    }

    fn set(
        &self,
        _client: AnyClient,
        parameters: Vec<Parameter>,
        _request_id: Option<String>,
        responder: SetParametersResponder,
    ) {
        for parameter in &parameters {
            let said = self
                .parameters
                .set(&parameter.name, &value(parameter))
                .unwrap_or_else(|why| Some(format!("a parameter is not set: {why}")));
            if let Some(note) = said {
                self.desk.say(note);
            }
        }
        // The current values, which may differ from the requested ones.
        let names: Vec<String> = parameters
            .into_iter()
            .map(|parameter| parameter.name)
            .collect();
        responder.respond(self.named(&names));
    }
}
