//! Folders of ROS packages.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use xacro_expand::{Files, Host, Unread, find_package};

use crate::files::FileAccess;

/// A ROS package and its folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
}

/// The machine as visible with the loading options: the accessible files and the given packages.
/// The environment is hidden if files are restricted.
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    /// The packages with given folders.
    pub(crate) given: Vec<Package>,
    pub(crate) files: FileAccess,
}

impl Machine {
    /// Returns the folder of a package named by a file in `from`: the given one, or one around the
    /// file that contains the sought file.
    pub(crate) fn find(
        &self,
        from: &Path,
        package: &str,
        holds: &dyn Fn(&Path) -> bool,
    ) -> Option<PathBuf> {
        let given = self.given.iter().find(|p| p.name == package);
        match given {
            Some(given) => Some(given.folder.clone()),
            None => find_package(self, from, package, holds),
        }
    }
}

impl Files for Machine {
    fn read_text(&self, path: &Path, most_bytes: u64) -> Result<String, Unread> {
        let text = self.files.read_text(path, most_bytes);
        text.map_err(|fault| Unread {
            is_missing: fault.is_missing(),
            reason: fault.to_string(),
        })
    }

    fn names_in(&self, folder: &Path, most: usize) -> Vec<String> {
        self.files.names_in(folder, most)
    }

    fn is_folder(&self, path: &Path) -> bool {
        self.files.is_folder(path)
    }
}

impl Host for Machine {
    fn package(&self, name: &str, from: &Path) -> Option<PathBuf> {
        let found = self.find(from, name, &|folder| self.files.is_folder(folder))?;
        // Includes from there are relative to that file's folder, not to the working folder.
        Some(std::path::absolute(&found).unwrap_or(found))
    }

    fn environment(&self, name: &str) -> Result<Option<String>, String> {
        if self.files.is_confined() {
            // A file could copy whatever it can look up into its expansion.
            let words = "nothing of the environment is shown where only some files may be read";
            return Err(words.to_owned());
        }
        Ok(std::env::var(name).ok())
    }

    fn working_folder(&self) -> Result<String, String> {
        if self.files.is_confined() {
            let words = "the working folder is not shown where only some files may be read";
            return Err(words.to_owned());
        }
        let folder = std::env::current_dir().unwrap_or_default();
        Ok(folder.display().to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::LoadOptions;

    #[test]
    fn a_folder_that_is_given_is_taken() {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir(root.path().join("robot_meshes")).unwrap();
        let elsewhere = root.path().join("elsewhere");
        let mut options = LoadOptions::default();
        let found = |options: &LoadOptions| {
            options
                .machine()
                .find(root.path(), "robot_meshes", &Path::is_dir)
        };
        assert_eq!(found(&options), Some(root.path().join("robot_meshes")));
        options.packages.push(Package {
            name: "robot_meshes".to_owned(),
            folder: elsewhere.clone(),
        });
        assert_eq!(found(&options), Some(elsewhere));
    }
}
