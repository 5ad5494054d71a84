//! Finds the place in a scenario's text of an error that is detected only with the robot.

use std::ops::Range;
use std::sync::Arc;

use ilon_formats::Fault;
use miette::NamedSource;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::scenario::checks::objection::Objection;
use crate::{Error, ScenarioFault};

/// The text that a scenario was read from; empty for one that was built in memory.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// The file's name and content.
    read: Option<Arc<(String, String)>>,
    /// Keys that settings changed, for which the text is not the origin.
    changed: Vec<Vec<String>>,
}

impl Source {
    pub(super) fn of(name: &str, text: &str, changed: Vec<Vec<String>>) -> Self {
        Self {
            read: Some(Arc::new((name.to_owned(), text.to_owned()))),
            changed,
        }
    }

    /// The error with the lines of the scenario's file that it concerns, if they are known.
    pub fn placed(&self, error: Error) -> Error {
        match error {
            Error::Invalid { message, help } => match self.find(&message) {
                Some((source_code, span)) => {
                    ScenarioFault::new(message, help, (source_code, span.into())).into()
                }
                None => Error::Invalid { message, help },
            },
            Error::Robot(fault) => {
                let named = of_scenario(fault.fault.fault());
                match named.and_then(|named| self.find(&named)) {
                    Some((text, span)) => Error::Robot(Box::new(fault.placed(text, span))),
                    None => Error::Robot(fault),
                }
            }
            other => other,
        }
    }

    /// The place of what a message names between backticks: a key with its tables, or a value that
    /// occurs once.
    fn find(&self, message: &str) -> Option<(NamedSource<String>, Range<usize>)> {
        let (name, text) = self.read.as_deref()?;
        let document = DeTable::parse(text).ok()?;
        let document = document.get_ref();
        let mut quoted = message.split('`').skip(1).step_by(2);
        let span = quoted.find_map(|quoted| {
            let of_key = || self.key(document, quoted);
            of_key().or_else(|| the_value(document, quoted))
        })?;
        Some((NamedSource::new(name, text.clone()), span))
    }

    fn key(&self, document: &DeTable<'_>, key: &str) -> Option<Range<usize>> {
        let parts: Vec<&str> = key.split('.').collect();
        if self.changed.iter().any(|changed| *changed == parts) {
            return None;
        }
        let (path, span) = Objection::to(key, "", "").place(document)?;
        (path == parts).then_some(span)
    }
}

/// The place of a text that occurs exactly once as a value.
fn the_value(document: &DeTable<'_>, text: &str) -> Option<Range<usize>> {
    let mut found = None;
    let mut left: Vec<&Spanned<DeValue<'_>>> = document.values().collect();
    while let Some(value) = left.pop() {
        match value.get_ref() {
            DeValue::String(word) if word == text && found.is_some() => return None,
            DeValue::String(word) if word == text => found = Some(value.span()),
            DeValue::Array(items) => left.extend(items),
            DeValue::Table(table) => left.extend(table.values()),
            _ => {}
        }
    }
    found
}

/// For a fault of a robot's file that the scenario causes: its keys and values, between backticks;
/// otherwise `None`.
fn of_scenario(fault: &Fault) -> Option<String> {
    match fault {
        Fault::Unreadable { .. } => Some("`robot.file`".to_owned()),
        Fault::UnknownJoint { joint, .. } | Fault::NoSuchJoint { joint, .. } => {
            Some(format!("`robot.joints.{joint}` `{joint}`"))
        }
        _ => None,
    }
}
