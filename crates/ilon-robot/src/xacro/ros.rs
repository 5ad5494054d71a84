//! The xacro of ROS, where a program has it at hand: it is asked about files whose language ilon's own expander does not know whole.
//!
//! What both expand they expand alike (`tests/xacro` holds it), so that ilon's own goes first: it is quick, names the place of every
//! fault, and its time and memory have limits, which the other's have not.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::{Failure, Reason, Settings, packages};

/// Finds the folder of a package by its name.
pub type FindPackage = Box<dyn Fn(&str) -> Option<PathBuf> + Send + Sync>;

/// What expands a file with arguments: gives the URDF and what it was that expanded it, such as `xacro 2.1.1`; `None` where it cannot
/// be had, or refuses the file.
pub type RosXacro = fn(&Path, &BTreeMap<String, String>, FindPackage) -> Option<(String, String)>;

static ROS_XACRO: OnceLock<RosXacro> = OnceLock::new();

/// Has the xacro of ROS asked about files that ilon's own expander refuses for their language, in this process from now on. The first
/// that is given counts. Files of a sandbox are never shown to it.
pub fn use_ros_xacro(expander: RosXacro) {
    let _ = ROS_XACRO.set(expander);
}

/// What the xacro of ROS makes of a file that was refused, and what is said of it.
pub(crate) fn expanded_by_ros(
    path: &Path,
    settings: &Settings,
    failure: &Failure,
) -> Option<(String, String)> {
    let Reason::Other(reason) = &failure.reason else {
        return None;
    };
    // What is missing is missing for the other too, and is better named here.
    let is_of_language = !failure.of_missing && failure.missing.is_empty();
    if settings.files.is_confined() || !is_of_language || !path.is_file() {
        return None;
    }
    let around = packages(path.parent().unwrap_or(Path::new("")), settings);
    let find: FindPackage = Box::new(move |name| around.find(name, |_| true));
    let (text, by) = ROS_XACRO.get()?(path, settings.arguments, find)?;
    Some((
        text,
        format!("expanded by {by}, because ilon's own expander refuses it: {reason}"),
    ))
}
