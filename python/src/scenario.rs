//! Scenarios as Python names them: by a path, or as a dict of what the file would hold.

use std::path::PathBuf;

use ilon::Scenario;
use ilon::scenario::Setting;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyString};
use toml::{Table, Value};

use crate::errors::OrRaise;
use crate::values::to_toml;

/// What a scenario that is no file is called.
const NAMELESS: &str = "scenario";

/// Keys of a scenario, such as `world.floor.friction`, and what they shall be.
pub type Settings = Vec<(String, Value)>;

/// Reads a scenario from a path, or takes it from a dict; some of its keys may be set anew.
///
/// Relative paths of a dict start from `folder`, or from where the program runs.
pub fn read(
    source: &Bound<'_, PyAny>,
    settings: Option<&Bound<'_, PyMapping>>,
    folder: Option<PathBuf>,
) -> PyResult<Scenario> {
    let py = source.py();
    let settings = match settings {
        Some(settings) => read_settings(settings)?,
        None => Settings::new(),
    };
    if let Ok(mapping) = source.cast::<PyMapping>() {
        let Value::Table(mut table) = to_toml(mapping.as_any())? else {
            return Err(PyTypeError::new_err("a scenario is a dict or a path"));
        };
        set_all(&mut table, &settings)?;
        return of_table(&table, NAMELESS, folder.unwrap_or_default()).or_raise(py);
    }
    if !(source.is_instance_of::<PyString>() || source.hasattr("__fspath__")?) {
        return Err(PyTypeError::new_err(format!(
            "a scenario is the path of a file or a dict, not a {}",
            source.get_type().name()?
        )));
    }
    if folder.is_some() {
        return Err(PyTypeError::new_err(
            "`folder` is for scenarios given as a dict; the paths of a file start from its own folder",
        ));
    }
    let path: PathBuf = source.extract()?;
    let settings: Vec<Setting> = settings
        .iter()
        .map(|(key, value)| format!("{key}={value}").parse())
        .collect::<Result<_, String>>()
        .map_err(PyValueError::new_err)?;
    py.detach(|| Scenario::load_with(path, &settings))
        .or_raise(py)
}

/// Settings as Python writes them: `{"world.floor.friction": 0.2}`.
pub fn read_settings(settings: &Bound<'_, PyMapping>) -> PyResult<Settings> {
    let mut read = Settings::new();
    for item in settings.items()?.iter() {
        let (key, value): (String, Bound<'_, PyAny>) = item.extract()?;
        read.push((key, to_toml(&value)?));
    }
    Ok(read)
}

/// A scenario from its table.
pub fn of_table(table: &Table, name: &str, folder: PathBuf) -> Result<Scenario, ilon::Error> {
    Scenario::from_toml(&table.to_string(), name, folder)
}

/// Sets keys of a scenario's table.
pub fn set_all(table: &mut Table, settings: &Settings) -> PyResult<()> {
    for (key, value) in settings {
        set(table, key, value.clone()).map_err(PyValueError::new_err)?;
    }
    Ok(())
}

/// Sets one key of a table by its dotted name; a number in it is a place in a list. Tables on the way are made.
pub fn set(table: &mut Table, key: &str, value: Value) -> Result<(), String> {
    let Some((first, rest)) = key.split_once('.') else {
        if key.is_empty() {
            return Err(
                "the name of a setting is empty; write such as world.floor.friction".into(),
            );
        }
        table.insert(key.to_owned(), value);
        return Ok(());
    };
    let inner = table
        .entry(first)
        .or_insert_with(|| Value::Table(Table::new()));
    set_in(inner, first, rest, value)
}

fn set_in(slot: &mut Value, name: &str, key: &str, value: Value) -> Result<(), String> {
    match slot {
        Value::Table(table) => set(table, key, value),
        Value::Array(items) => {
            let (index, rest) = match key.split_once('.') {
                Some((index, rest)) => (index, Some(rest)),
                None => (key, None),
            };
            let count = items.len();
            let item = index
                .parse()
                .ok()
                .and_then(|index: usize| items.get_mut(index));
            let Some(item) = item else {
                return Err(format!(
                    "`{name}` is a list of {count}, of which there is no `{index}`; places count from 0"
                ));
            };
            match rest {
                Some(rest) => set_in(item, name, rest, value),
                None => {
                    *item = value;
                    Ok(())
                }
            }
        }
        _ => {
            // What was a word, such as `heading = "along_path"`, becomes the table that is asked for.
            let mut table = Table::new();
            set(&mut table, key, value)?;
            *slot = Value::Table(table);
            Ok(())
        }
    }
}
