//! Finds ROS packages around a file.

use std::path::{Path, PathBuf};

use crate::files::Files;

/// Number of folders searched above a robot's file.
const MOST_ABOVE: usize = 8;
/// Largest number of names read in a folder.
const MOST_NAMES: usize = 1000;
/// Largest `package.xml` that is read, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Returns the folder of a package around `from`, the folder of the file that names it: the one
/// with this name that contains the sought file.
///
/// A description usually lies inside its package, packages lie side by side, and repositories of
/// packages do too. A folder of another name is the package if its `package.xml` says so. The
/// package of the file itself comes first: it may contain a Python module with its own name.
pub fn find_package(
    files: &dyn Files,
    from: &Path,
    package: &str,
    holds: &dyn Fn(&Path) -> bool,
) -> Option<PathBuf> {
    // A name is a single part of a path.
    if package.is_empty() || package == "." || package == ".." || package.contains(['/', '\\']) {
        return None;
    }
    let absolute = absolute(from);
    let above: Vec<&Path> = absolute.ancestors().take(MOST_ABOVE).collect();
    let own = above
        .iter()
        .find(|above| declares(files, above, package) && holds(above));
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
            .flat_map(|above| around_folder(files, above, package));
        let mut around = around.filter(|folder| holds(folder));
        around.next()
    })
}

/// Returns the only folder around `from` that contains files at all of some paths: a package under
/// another name. `None` if there is none, or more than one, or the paths are not specific.
pub fn folder_that_holds(files: &dyn Files, from: &Path, paths: &[&str]) -> Option<PathBuf> {
    let absolute = absolute(from);
    let holds = |folder: &PathBuf| {
        let parts = paths.iter().map(|path| folder.join(path));
        let mut there = parts.map(|path| {
            let (above, name) = (path.parent()?, path.file_name()?.to_str()?);
            let names = files.names_in(above, MOST_NAMES);
            names.iter().any(|of| of == name).then_some(())
        });
        there.all(|found| found.is_some())
    };
    // At least two plain parts: a bare name may exist anywhere.
    let is_telling = |path: &&str| path.contains('/') && !path.contains("..");
    if paths.is_empty() || !paths.iter().all(is_telling) {
        return None;
    }
    let above: Vec<&Path> = absolute.ancestors().take(MOST_ABOVE).collect();
    let below = |above: &&Path| -> Vec<PathBuf> {
        // The root of the file system is not a workspace.
        if above.parent().is_none() {
            return Vec::new();
        }
        let names = files.names_in(above, MOST_NAMES).into_iter();
        let folders = names.map(|name| above.join(name));
        std::iter::once(above.to_path_buf())
            .chain(folders)
            .collect()
    };
    let mut found: Vec<PathBuf> = above.iter().flat_map(below).filter(holds).collect();
    found.sort();
    found.dedup();
    match &found[..] {
        [folder] => Some(folder.clone()),
        _ => None,
    }
}

/// A folder from the root on; the folder of a file that is named alone is empty, and the working
/// folder.
pub(crate) fn absolute(folder: &Path) -> PathBuf {
    let named = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    std::path::absolute(named).unwrap_or_else(|_| folder.to_owned())
}

/// Returns folders in and below `above` that may be the package under another name, or one level
/// further down.
fn around_folder(files: &dyn Files, above: &Path, package: &str) -> Vec<PathBuf> {
    // The root of the file system is not a workspace.
    if above.parent().is_none() {
        return Vec::new();
    }
    let mut found = Vec::new();
    if declares(files, above, package) {
        found.push(above.to_owned());
    }
    for name in files.names_in(above, MOST_NAMES) {
        let beside = above.join(&name);
        if !name.starts_with('.') && files.is_folder(&beside) {
            if declares(files, &beside, package) {
                found.push(beside.clone());
            }
            let inside = beside.join(package);
            if files.is_folder(&inside) {
                found.push(inside);
            }
        }
    }
    found
}

/// Whether the `package.xml` of a folder has that name.
fn declares(files: &dyn Files, folder: &Path, package: &str) -> bool {
    let manifest = folder.join("package.xml");
    let text = files.read_text(&manifest, MAX_BYTES);
    text.is_ok_and(|text| {
        let name = text
            .split_once("<name>")
            .and_then(|(_, rest)| rest.split_once("</name>"));
        name.is_some_and(|(name, _)| name.trim() == package)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::{Host as _, LocalHost};
    use crate::settings::Settings;

    /// A workspace with two repositories of two packages each; the robot's file is in the first.
    fn workspace() -> (tempfile::TempDir, PathBuf) {
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
        (root, folder)
    }

    fn found(from: &Path, name: &str) -> Option<String> {
        let folder = find_package(&LocalHost::default(), from, name, &Path::is_dir)?;
        let parts: Vec<_> = folder.iter().map(|p| p.to_string_lossy()).collect();
        Some(parts[parts.len() - 2..].join("/"))
    }

    #[test]
    fn packages_lie_around_the_file() {
        let (_root, from) = workspace();
        let found = |name| found(&from, name);
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
        let (root, from) = workspace();
        let package = root.path().join("ws/src/robots/robot_description");
        std::fs::create_dir(package.join("robot_description")).unwrap();
        let manifest = "<package><name>robot_description</name></package>";
        std::fs::write(package.join("package.xml"), manifest).unwrap();
        assert_eq!(
            find_package(
                &LocalHost::default(),
                &from,
                "robot_description",
                &Path::is_dir
            ),
            Some(package)
        );
    }

    /// `ilon inspect robot.urdf` where the file lies: its folder is the working folder.
    #[test]
    fn around_a_file_that_is_named_without_its_folder_is_around_the_working_folder() {
        let (here, host) = (std::env::current_dir().unwrap(), LocalHost::default());
        let sought = here.parent().unwrap().join("robot_meshes");
        let holds = |folder: &Path| folder == sought;
        for from in ["", "."] {
            let found = find_package(&host, Path::new(from), "robot_meshes", &holds);
            assert_eq!(found.as_ref(), Some(&sought), "from `{from}`");
        }
        let holds = folder_that_holds(&host, Path::new(""), &["src/substitution.rs"]);
        assert_eq!(holds.as_ref(), Some(&here));
        let text = "<robot name=\"$(dirname)\"/>";
        let expanded = crate::expand(Path::new("r.xacro"), text, &Settings::default(), &host);
        let named = format!("name=\"{}\"", here.display());
        assert!(expanded.unwrap().text.contains(&named), "{named}");
    }

    #[test]
    fn a_folder_that_is_given_is_taken() {
        let (root, from) = workspace();
        let elsewhere = root.path().join("elsewhere");
        let host = LocalHost {
            packages: [("robot_meshes".to_owned(), elsewhere.clone())].into(),
        };
        assert_eq!(host.package("robot_meshes", &from), Some(elsewhere));
    }
}
