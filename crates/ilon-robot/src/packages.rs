//! Where ROS packages lie.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::files::FileAccess;

/// How many folders above a robot's file are looked through.
const MOST_ABOVE: usize = 8;
/// How many names of a folder are looked at.
const MOST_NAMES: usize = 1000;
/// Longest `package.xml` that is read, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// A ROS package and its folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
}

/// Finds packages for a file.
#[derive(Clone, Debug)]
pub(crate) struct Packages {
    /// The folder of the file that names them.
    folder: PathBuf,
    given: Vec<Package>,
    files: FileAccess,
}

impl Packages {
    /// For a file in `folder`; those of which the folder is given are found there.
    pub(crate) fn around(folder: &Path, given: &[Package], files: &FileAccess) -> Self {
        Self {
            folder: folder.to_owned(),
            given: given.to_vec(),
            files: files.clone(),
        }
    }

    /// The folder of a package: the one that is given for it, or one of its name around the file, that holds what is sought.
    ///
    /// A description usually lies inside its package, packages lie side by side, and repositories of packages do too. A
    /// folder of another name is the package where its `package.xml` says so. The package that the file itself lies in comes first:
    /// it may hold a Python module of its own name.
    pub(crate) fn find(&self, package: &str, holds: impl Fn(&Path) -> bool) -> Option<PathBuf> {
        if let Some(given) = self.given.iter().find(|p| p.name == package) {
            return Some(given.folder.clone());
        }
        // A name is one part of a path and nothing else.
        if package.is_empty() || package == "." || package == ".." || package.contains(['/', '\\'])
        {
            return None;
        }
        let absolute = std::path::absolute(&self.folder).unwrap_or_else(|_| self.folder.clone());
        let above: Vec<&Path> = absolute.ancestors().take(MOST_ABOVE).collect();
        let own = above
            .iter()
            .find(|above| self.declares(above, package) && holds(above));
        if let Some(own) = own {
            return Some(own.to_path_buf());
        }
        let by_name = above
            .iter()
            .flat_map(|above| [above.join(package), above.join("meshes").join(package)])
            .find(|folder| holds(folder));
        by_name.or_else(|| {
            let around = above
                .iter()
                .flat_map(|above| self.around_folder(above, package));
            let mut around = around.filter(|folder| holds(folder));
            around.next()
        })
    }

    /// Folders in and below `above` that could be the package under another name, or a level further down.
    fn around_folder(&self, above: &Path, package: &str) -> Vec<PathBuf> {
        // The root of the file system is no workspace.
        if above.parent().is_none() {
            return Vec::new();
        }
        let mut found = Vec::new();
        if self.declares(above, package) {
            found.push(above.to_owned());
        }
        for name in self.files.names_in(above, MOST_NAMES) {
            let beside = above.join(&name);
            if !name.starts_with('.') && self.files.is_folder(&beside) {
                if self.declares(&beside, package) {
                    found.push(beside.clone());
                }
                let inside = beside.join(package);
                if self.files.is_folder(&inside) {
                    found.push(inside);
                }
            }
        }
        found
    }

    /// Whether the `package.xml` of a folder gives it that name.
    fn declares(&self, folder: &Path, package: &str) -> bool {
        let manifest = folder.join("package.xml");
        let text = self.files.read_text(&manifest, MAX_BYTES);
        text.is_ok_and(|text| {
            let name = text
                .split_once("<name>")
                .and_then(|(_, rest)| rest.split_once("</name>"));
            name.is_some_and(|(name, _)| name.trim() == package)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A workspace with two repositories of two packages each; the robot's file is in the first.
    fn workspace() -> (tempfile::TempDir, Packages) {
        let root = tempfile::tempdir().unwrap();
        for folder in [
            "ws/src/robots/robot_description/urdf",
            "ws/src/robots/robot_meshes",
            "ws/src/sensors/camera_description",
            "ws/src/sensors-main/named_otherwise",
        ] {
            std::fs::create_dir_all(root.path().join(folder)).unwrap();
        }
        std::fs::write(
            root.path().join("ws/src/sensors-main/package.xml"),
            "<package><name> lidar_description </name></package>",
        )
        .unwrap();
        let folder = root.path().join("ws/src/robots/robot_description/urdf");
        let packages = Packages::around(&folder, &[], &FileAccess::anywhere());
        (root, packages)
    }

    fn found(packages: &Packages, name: &str) -> Option<String> {
        let folder = packages.find(name, Path::is_dir)?;
        let parts: Vec<_> = folder.iter().map(|p| p.to_string_lossy()).collect();
        Some(parts[parts.len() - 2..].join("/"))
    }

    #[test]
    fn packages_lie_around_the_file() {
        let (_root, packages) = workspace();
        let found = |name| found(&packages, name);
        assert_eq!(
            found("robot_description").as_deref(),
            Some("robots/robot_description")
        );
        assert_eq!(
            found("robot_meshes").as_deref(),
            Some("robots/robot_meshes")
        );
        assert_eq!(
            found("camera_description").as_deref(),
            Some("sensors/camera_description")
        );
        assert_eq!(
            found("lidar_description").as_deref(),
            Some("src/sensors-main")
        );
        assert_eq!(found("not_there"), None);
        for no_name in ["", ".", "..", "../sensors", "a/b"] {
            assert_eq!(found(no_name), None, "{no_name}");
        }
    }

    #[test]
    fn the_package_of_the_file_comes_before_its_module_of_the_same_name() {
        let (root, packages) = workspace();
        let package = root.path().join("ws/src/robots/robot_description");
        std::fs::create_dir(package.join("robot_description")).unwrap();
        let manifest = "<package><name>robot_description</name></package>";
        std::fs::write(package.join("package.xml"), manifest).unwrap();
        assert_eq!(
            packages.find("robot_description", Path::is_dir),
            Some(package)
        );
    }

    #[test]
    fn a_folder_that_is_given_is_taken() {
        let (root, _) = workspace();
        let given = Package {
            name: "robot_meshes".to_owned(),
            folder: root.path().join("elsewhere"),
        };
        let packages = Packages::around(root.path(), &[given], &FileAccess::anywhere());
        assert_eq!(
            packages.find("robot_meshes", Path::is_dir),
            Some(root.path().join("elsewhere"))
        );
    }
}
