//! An impossible demand of a scenario, and its place in the text.

use std::ops::Range;

use ilon_files::keys::place_of;
use toml::de::DeTable;

use crate::Error;

/// An [`Objection`]: its key, what is wrong, and how to repair it, each as `format!` takes it.
macro_rules! objection {
    ($key:literal, $message:literal, $help:literal $(,)?) => {
        $crate::scenario::checks::objection::Objection::to(
            format!($key),
            format!($message),
            format!($help),
        )
    };
}

/// Returns with an objection where something is wrong.
macro_rules! object_if {
    ($is_wrong:expr, $($objection:tt)+) => {
        if $is_wrong {
            return Err($crate::scenario::checks::objection::objection!($($objection)+));
        }
    };
}

/// The names of keys of a section, each with whether it is given.
macro_rules! given {
    ($of:expr, $($key:ident),+ $(,)?) => {
        [$((stringify!($key), $of.$key.is_some())),+]
    };
}

pub(in crate::scenario) use {given, object_if, objection};

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
