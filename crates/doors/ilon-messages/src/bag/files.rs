//! The files of a bag in its folder.

use std::fs;
use std::io;
use std::path::Path;

use super::BagError;

/// The messages.
pub(super) const FILE: &str = "bag_0.mcap";
/// The messages during writing, and of an interrupted bag.
pub(super) const UNFINISHED_FILE: &str = "bag_0.mcap.ilon-partial";
/// The metadata for ROS 2.
pub(super) const METADATA: &str = "metadata.yaml";
/// The metadata during writing.
pub(super) const UNFINISHED_METADATA: &str = ".metadata.yaml.ilon-partial";
/// All of them, of a bag finished or not.
pub(super) const FILES: [&str; 4] = [FILE, UNFINISHED_FILE, METADATA, UNFINISHED_METADATA];

/// Removes a file, if it exists.
pub(super) fn remove_if_there(path: &Path) -> Result<(), BagError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(BagError::io(path)(error)),
        _ => Ok(()),
    }
}
