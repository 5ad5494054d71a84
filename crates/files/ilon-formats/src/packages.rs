//! Where ROS packages lie.

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

/// The machine as the options of loading show it: the files that may be read, packages that are given, and of the environment
/// nothing where only some files may be read.
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    /// The packages whose folders are given.
    pub(crate) given: Vec<Package>,
    pub(crate) files: FileAccess,
}

impl Machine {
    /// The folder of a package that a file in `from` names: the one that is given for it, or one around the file that holds what is
    /// sought.
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
        // What a file includes by it is sought from that file's folder, and not from where the command is called.
        Some(std::path::absolute(&found).unwrap_or(found))
    }

    fn environment(&self, name: &str) -> Result<Option<String>, String> {
        if self.files.is_confined() {
            // What a file can look up, it can repeat in what it becomes.
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
