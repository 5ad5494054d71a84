//! What an expansion may see of the machine that it runs on.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::files::{Files, Unread};
use crate::packages::find_package;

/// Everything that an expansion may ask of the machine: files, packages, and what `$(env)` and `$(cwd)` show.
///
/// [`LocalHost`] is one that reads any file. A program that expands files of strangers gives a host of its own, which reads only
/// what they may see and refuses the environment.
pub trait Host: Files + Sync {
    /// The folder of a ROS package that a file in `from` names.
    fn package(&self, name: &str, from: &Path) -> Option<PathBuf>;

    /// A variable of the environment, `None` where it is not set.
    ///
    /// # Errors
    /// Why the environment is not shown, in words.
    fn environment(&self, name: &str) -> Result<Option<String>, String>;

    /// The folder in which the program runs.
    ///
    /// # Errors
    /// Why it is not shown, in words.
    fn working_folder(&self) -> Result<String, String>;
}

/// A host that reads any file and shows the environment. Packages have the folders that are named here, and otherwise those that
/// [`find_package`] finds around the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LocalHost {
    /// Folders of packages, by their names.
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
        // Before it is opened: opening a pipe waits for whoever writes to it.
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
