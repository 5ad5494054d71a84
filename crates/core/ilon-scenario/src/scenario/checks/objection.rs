//! An impossible demand of a scenario, and its place in the text.

use std::ops::Range;

use ilon_files::keys::place_of;
use toml::de::DeTable;

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
        place_of(document, &self.key)
    }
}

impl From<Objection> for Error {
    fn from(objection: Objection) -> Self {
        Self::invalid(objection.message, objection.help)
    }
}
