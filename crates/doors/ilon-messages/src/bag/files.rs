//! The files of a bag in its folder.

use std::fs;
use std::io;
use std::path::Path;

use super::BagError;

/// Its messages.
pub(super) const FILE: &str = "bag_0.mcap";
/// The same while it is written, and of a bag that was cut short.
pub(super) const UNFINISHED_FILE: &str = "bag_0.mcap.ilon-partial";
/// What ROS 2 wants to know of them.
pub(super) const METADATA: &str = "metadata.yaml";
/// The same while it is written.
pub(super) const UNFINISHED_METADATA: &str = ".metadata.yaml.ilon-partial";

/// Removes a file, if there is one.
pub(super) fn remove_if_there(path: &Path) -> Result<(), BagError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(BagError::io(path)(error)),
        _ => Ok(()),
    }
}
