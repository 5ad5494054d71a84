//! Reads descriptions, and reports all faults of their keys and values, each with its place.

use std::path::Path;
use std::sync::Arc;

use ilon_files::keys;
use ilon_files::toml::{DecodeError, decode, parse};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use toml::Table;

use super::check::check;
use super::{MAX_BYTES, Spec, changed};
use crate::error::{Fault, RobotError};
use crate::files::FileAccess;

impl Spec {
    /// Reads a description from a TOML file.
    ///
    /// # Errors
    /// A file that cannot be read; TOML that is malformed, of another form, or has unknown keys.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, RobotError> {
        Self::load_through(path, &FileAccess::anywhere())
    }

    /// Reads a description from an accessible TOML file.
    ///
    /// # Errors
    /// Those of [`Self::load`], and an inaccessible file.
    pub fn load_through(path: impl AsRef<Path>, files: &FileAccess) -> Result<Self, RobotError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text = files
            .read_text(path, MAX_BYTES)
            .map_err(|e| RobotError::new(&file, Fault::unreadable(e)))?;
        Self::from_toml_str_with(&text, &file, &Table::new())
    }

    /// Reads a description from TOML; `file` is its name in errors.
    ///
    /// # Errors
    /// TOML that is malformed, of another form, or has unknown keys.
    pub fn from_toml_str(text: &str, file: &str) -> Result<Self, RobotError> {
        read(text, file, &Table::new())
    }

    /// Reads a description from TOML with changed keys, see [`crate::LoadOptions::spec`].
    ///
    /// # Errors
    /// Those of [`Self::from_toml_str`], and values out of their ranges.
    pub(crate) fn from_toml_str_with(
        text: &str,
        file: &str,
        changes: &Table,
    ) -> Result<Self, RobotError> {
        let spec: Self = read(text, file, changes)?;
        let checked = check(&spec, &spec.described());
        checked.map_err(|error| placed(error, text, file, changes))?;
        Ok(spec)
    }
}

/// Reads a description with changed keys; reports all faults of its keys at once.
pub(super) fn read<T: DeserializeOwned + JsonSchema>(
    text: &str,
    file: &str,
    changes: &Table,
) -> Result<T, RobotError> {
    let of_toml = |fault: DecodeError| {
        let (reason, help) = (fault.message, String::new());
        let error = RobotError::new(file, Fault::Toml { reason, help });
        match fault.span {
            Some(bytes) => error.at(&text.into(), bytes),
            None => error,
        }
    };
    let document = parse(text).map_err(of_toml)?;
    let schema = schemars::schema_for!(T).to_value();
    let whole: Arc<str> = text.into();
    let faults = keys::check(&document, &schema, false).into_iter();
    let errors = faults.map(|fault| {
        let (reason, help) = (fault.message, fault.help);
        RobotError::new(file, Fault::Toml { reason, help }).at(&whole, fault.span)
    });
    if let Some(error) = RobotError::of_all(errors) {
        return Err(error);
    }
    if changes.is_empty() {
        return decode(document).map_err(of_toml);
    }
    let mut table: Table = decode(document).map_err(of_toml)?;
    changed::lay_over(&mut table, changes);
    read(&table.to_string(), file, &Table::new()).map_err(|error| {
        error.each(|error| {
            let reason = format!("with its keys changed: {}", error.fault());
            let help = error.help();
            RobotError::new(file, Fault::Toml { reason, help })
        })
    })
}

/// Adds the file and, unless they come from changes, the places of values out of their ranges.
pub(super) fn placed(error: RobotError, text: &str, file: &str, changes: &Table) -> RobotError {
    let document = parse(text).ok();
    let is_changed = |key: &str| {
        let mut parts = key.split('.');
        let first = parts.next().and_then(|part| changes.get(part));
        parts
            .try_fold(first, |at, part| at.map(|at| at.get(part)))
            .flatten()
            .is_some()
    };
    let text: Arc<str> = text.into();
    error.each(|error| {
        let span = match (error.fault().key(), &document) {
            (Some(key), Some(document)) if !is_changed(key) => {
                keys::place_of(document.get_ref(), key).map(|(_, span)| span)
            }
            _ => None,
        };
        match span {
            Some(span) => error.of_file(file).at(&text, span),
            None => error.of_file(file),
        }
    })
}
