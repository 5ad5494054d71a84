//! Expands xacro, the macro language in which URDF is written at source, without a ROS installation.

use std::any::Any;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use xacro_rs::XacroProcessor;
use xacro_rs::extensions::ExtensionHandler;

use super::mesh::folder_of;
use super::options::Package;

/// Longest that an expansion may take: real ones take a fraction of a second, and macros that call each other twice over
/// never end.
const LONGEST: Duration = Duration::from_secs(10);
/// Stack of the thread that expands: macros within macros.
const STACK_BYTES: usize = 64 << 20;

/// The expanded text of a xacro file, or why it could not be expanded.
pub(super) fn expand(path: &Path, packages: &[Package]) -> Result<String, String> {
    expand_within(LONGEST, path, packages)
}

/// Expansion runs on a thread of its own, so that it can be left behind when it does not end.
fn expand_within(longest: Duration, path: &Path, packages: &[Package]) -> Result<String, String> {
    let (sender, receiver) = mpsc::channel();
    let (path, packages) = (path.to_owned(), packages.to_vec());
    let expansion = move || {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let expanded = XacroProcessor::builder()
            .with_compat_all()
            .with_extension(Box::new(Find { folder, packages }))
            .build()
            .run(&path)
            .map_err(|e| e.to_string());
        // Nobody listens any more where it took too long.
        let _ = sender.send(expanded);
    };
    thread::Builder::new()
        .stack_size(STACK_BYTES)
        .spawn(expansion)
        .map_err(|e| e.to_string())?;
    match receiver.recv_timeout(longest) {
        Ok(expanded) => expanded,
        Err(mpsc::RecvTimeoutError::Timeout) => Err(format!(
            "its macros do not come to an end within {} s",
            longest.as_secs_f64()
        )),
        Err(mpsc::RecvTimeoutError::Disconnected) => {
            Err("the expansion broke down without a word".to_owned())
        }
    }
}

/// `$(find PACKAGE)`: folders of packages are found as those of meshes are.
struct Find {
    folder: PathBuf,
    packages: Vec<Package>,
}

impl ExtensionHandler for Find {
    fn resolve(&self, command: &str, arguments: &str) -> Result<Option<String>, Box<dyn Error>> {
        if command != "find" {
            return Ok(None);
        }
        let package = arguments.trim();
        match folder_of(package, &self.folder, &self.packages, Path::is_dir) {
            Some(folder) => Ok(Some(folder.display().to_string())),
            None => Err(format!(
                "the folder of the package `{package}` is not known: say `--package {package}=FOLDER`"
            )
            .into()),
        }
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn macros_that_do_not_end_are_left_behind() {
        // Twenty macros that call the next one twice: a million links, which takes seconds and then ends.
        let mut text = String::from("<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">");
        for i in 0..20 {
            text += &format!(
                "<xacro:macro name=\"m{i}\" params=\"\"><xacro:m{0}/><xacro:m{0}/></xacro:macro>",
                i + 1
            );
        }
        text += "<xacro:macro name=\"m20\" params=\"\"><link/></xacro:macro><xacro:m0/></robot>";
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        let told = expand_within(Duration::from_millis(50), file.path(), &[]).unwrap_err();
        assert_eq!(told, "its macros do not come to an end within 0.05 s");
    }
}
