//! The scenario that a study varies.

use std::path::PathBuf;

use ilon_files::FileAccess;
use ilon_sim::Error;
use ilon_sim::scenario::{Scenario, Setting, read_text};
use serde::{Deserialize, Serialize};

/// The scenario that a study varies, with its text at the time of reading.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Base {
    /// Its name: that of its file, without the extension.
    pub name: String,
    /// Path of its file.
    pub path: PathBuf,
    /// The text of its file.
    pub text: String,
}

impl Base {
    /// Reads the scenario's file.
    pub fn read(path: PathBuf, files: &FileAccess) -> Result<Self, Error> {
        let text = read_text(&path, files)?;
        let name = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        Ok(Self { name, path, text })
    }

    /// Returns the scenario with changed keys.
    pub fn with(&self, settings: &[Setting], files: &FileAccess) -> Result<Scenario, Error> {
        Scenario::from_text(&self.text, &self.path, settings, files)
    }
}
