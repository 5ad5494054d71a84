//! An impossible demand of a scenario, and its place in the text.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use crate::Error;

/// An impossible demand of a scenario.
#[derive(Debug)]
pub(in crate::scenario) struct Objection {
    /// The key at fault, with its tables before it and dots between; empty if a key is missing.
    pub key: String,
    /// What is wrong.
    pub message: String,
    /// How to repair it.
    pub help: String,
}

impl Objection {
    pub fn to(key: impl Into<String>, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self {
            key: key.into(),
            message: message.into(),
            help: help.into(),
        }
    }

    /// The place of the key in a document, or of the innermost existing table around it.
    pub fn place(&self, document: &DeTable<'_>) -> Option<(Vec<String>, Range<usize>)> {
        let mut place = None;
        let mut path = Vec::new();
        let mut inside = Some(document);
        let mut items: &[toml::Spanned<DeValue<'_>>] = &[];
        for part in self.key.split('.').filter(|part| !part.is_empty()) {
            let in_table = |table: &'_ DeTable<'_>| {
                let entry = table.iter().find(|(key, _)| key.get_ref() == part);
                entry.map(|(key, _)| key.span())
            };
            let value = match inside {
                Some(table) => table.get(part),
                None => part.parse::<usize>().ok().and_then(|at| items.get(at)),
            };
            let Some(value) = value else { break };
            path.push(part.to_owned());
            // For a table the key is more informative than its first bracket.
            let span = match value.get_ref() {
                DeValue::Table(_) => inside.and_then(in_table).unwrap_or(value.span()),
                _ => value.span(),
            };
            place = Some((path.clone(), span));
            inside = value.get_ref().as_table();
            items = value.get_ref().as_array().map_or(&[], |array| array);
        }
        place
    }
}

impl From<Objection> for Error {
    fn from(objection: Objection) -> Self {
        Self::invalid(objection.message, objection.help)
    }
}
