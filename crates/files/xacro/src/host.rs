//! Access of an expansion to its machine.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::files::{Files, Unread};
use crate::packages::find_package;

/// Access to the machine: files, packages, and the values of `$(env)` and `$(cwd)`.
///
/// [`LocalHost`] reads any file. A program that expands untrusted files implements its own host,
/// which restricts files and rejects the environment.
pub trait Host: Files + Sync {
    /// Returns the folder of a ROS package named by a file in `from`.
    fn package(&self, name: &str, from: &Path) -> Option<PathBuf>;

    /// Returns an environment variable, `None` if it is not set.
    ///
    /// # Errors
    /// The reason why the environment is inaccessible.
    fn environment(&self, name: &str) -> Result<Option<String>, String>;

    /// Returns the working folder of the program.
    ///
    /// # Errors
    /// The reason why it is inaccessible.
    fn working_folder(&self) -> Result<String, String>;
}

/// A host that reads any file and the environment. Packages have the folders given here, otherwise
/// those found by [`find_package`] around the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LocalHost {
    /// Folders of packages, by name.
    pub packages: BTreeMap<String, PathBuf>,
}

impl Files for LocalHost {
    fn read_text(&self, path: &Path, most_bytes: u64) -> Result<String, Unread> {
        let refused = |reason: String| Unread {
            is_missing: false,
            reason,
        };
        let of_io = |error: std::io::Error| Unread {
            is_missing: error.kind() == ErrorKind::NotFound,
            reason: error.to_string(),
        };
        // Checked before opening, because opening a pipe blocks until someone writes to it.
        if !fs::metadata(path).map_err(of_io)?.is_file() {
            return Err(refused("it is not a file".to_owned()));
        }
        let mut bytes = Vec::new();
        let file = File::open(path).map_err(of_io)?;
        file.take(most_bytes.saturating_add(1))
            .read_to_end(&mut bytes)
            .map_err(of_io)?;
        if bytes.len() as u64 > most_bytes {
            return Err(refused(format!("it is larger than {most_bytes} bytes")));
        }
        let text =
            String::from_utf8(bytes).map_err(|_| refused("it is not UTF-8 text".to_owned()))?;
        // A byte order mark is no part of the text.
        Ok(text
            .strip_prefix('\u{feff}')
            .map_or(text.clone(), str::to_owned))
    }

    fn names_in(&self, folder: &Path, most: usize) -> Vec<String> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let mut names: Vec<String> = entries
            .filter_map(|entry| entry.file_name().into_string().ok())
            .take(most)
            .collect();
        names.sort();
        names
    }

    fn is_folder(&self, path: &Path) -> bool {
        path.is_dir()
    }
}

impl Host for LocalHost {
    fn package(&self, name: &str, from: &Path) -> Option<PathBuf> {
        let named = self.packages.get(name).cloned();
        named.or_else(|| find_package(self, from, name, &Path::is_dir))
    }

    fn environment(&self, name: &str) -> Result<Option<String>, String> {
        Ok(std::env::var(name).ok())
    }

    fn working_folder(&self) -> Result<String, String> {
        let folder = std::env::current_dir().unwrap_or_default();
        Ok(folder.display().to_string())
    }
}
