//! Scenarios from Python: a path, or a dict with the content of a file.

use std::path::PathBuf;

use ilon::Scenario;
use ilon::files::FileAccess;
use ilon::scenario::Setting;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyString};
use toml::Value;

use crate::errors::{OrRaise, refused};
use crate::values::to_toml;

/// The name of a scenario that is not a file.
const NAMELESS: &str = "scenario";

/// Keys of a scenario, such as `world.floor.friction`, with new values.
pub type Settings = Vec<(String, Value)>;

/// Reads a scenario from a path or a dict, with changed keys.
///
/// Relative paths of a dict start from `folder`, or from the working directory. The scenario and
/// all files that it names must be readable under `sandbox`.
pub fn read(
    source: &Bound<'_, PyAny>,
    settings: Option<&Bound<'_, PyAny>>,
    folder: Option<PathBuf>,
    files: &FileAccess,
) -> PyResult<Scenario> {
    let py = source.py();
    let settings = match settings {
        Some(settings) => as_settings(&read_settings(settings)?),
        None => Vec::new(),
    };
    match named(source, folder, "scenario", "scenarios")? {
        Named::Text(text, folder) => {
            Scenario::from_toml_with(&text, NAMELESS, folder, &settings, files).or_raise(py)
        }
        Named::File(path) => py
            .detach(|| Scenario::load_within(path, &settings, files))
            .or_raise(py),
    }
}

/// A path or a dict.
pub enum Named {
    /// A dict, as text, and the folder for its relative paths.
    Text(String, PathBuf),
    /// A file.
    File(PathBuf),
}

/// Reads a path or a dict; `what` and `many` name it in the singular and plural for errors.
pub fn named(
    source: &Bound<'_, PyAny>,
    folder: Option<PathBuf>,
    what: &str,
    many: &str,
) -> PyResult<Named> {
    if let Ok(mapping) = source.cast::<PyMapping>() {
        return match to_toml(mapping.as_any())? {
            Value::Table(table) => Ok(Named::Text(table.to_string(), folder.unwrap_or_default())),
            _ => Err(PyTypeError::new_err(format!(
                "a {what} is a dict or a path"
            ))),
        };
    }
    if !(source.is_instance_of::<PyString>() || source.hasattr("__fspath__")?) {
        return Err(PyTypeError::new_err(format!(
            "a {what} is the path of a file or a dict, not a {}",
            source.get_type().name()?
        )));
    }
    if folder.is_some() {
        return Err(PyTypeError::new_err(format!(
            "`folder` is for {many} given as a dict; the paths of a file start from its own folder"
        )));
    }
    Ok(Named::File(source.extract()?))
}

/// Settings from Python: `{"world.floor.friction": 0.2}`.
pub fn read_settings(settings: &Bound<'_, PyAny>) -> PyResult<Settings> {
    let Ok(settings) = settings.cast::<PyMapping>() else {
        return Err(PyTypeError::new_err(format!(
            "`settings` is a dict, such as {{\"world.floor.friction\": 0.2}}, not a {}",
            settings.get_type().name()?
        )));
    };
    let mut read = Settings::new();
    for item in settings.items()?.iter() {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let key = key.to_string();
        if key.split('.').any(|part| part.trim().is_empty()) {
            return Err(PyValueError::new_err(format!(
                "`{key}` names no key of a scenario; write such as world.floor.friction"
            )));
        }
        read.push((key, to_toml(&value)?));
    }
    Ok(read)
}

/// Settings for a scenario.
pub fn as_settings(settings: &Settings) -> Vec<Setting> {
    let settings = settings.iter();
    settings
        .map(|(key, value)| Setting::new(key, value))
        .collect()
}

/// Which files may be read: any without a `sandbox`, otherwise those below its folder or folders.
pub fn files(py: Python<'_>, sandbox: Option<&Bound<'_, PyAny>>) -> PyResult<FileAccess> {
    let Some(sandbox) = sandbox else {
        return Ok(FileAccess::anywhere());
    };
    let is_one = sandbox.is_instance_of::<PyString>() || sandbox.hasattr("__fspath__")?;
    let folders: Vec<PathBuf> = match is_one {
        true => vec![sandbox.extract()?],
        false => sandbox.extract().map_err(|_| {
            PyTypeError::new_err(
                "`sandbox` is the path of a folder, or a list of such paths, below which alone files are read",
            )
        })?,
    };
    if folders.is_empty() {
        return Err(PyValueError::new_err(
            "`sandbox` names no folder; name one below which files may be read, or leave it out",
        ));
    }
    FileAccess::below(&folders).map_err(|fault| {
        refused(
            py,
            "ReadError",
            &format!("`sandbox` cannot be the folder {fault}"),
            "name a folder that is there",
        )
    })
}
