//! The files that an expansion may read.

use std::path::Path;

/// Why a file is not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct Unread {
    /// Whether there is no such file, which an expansion may go without.
    pub is_missing: bool,
    /// The reason in words.
    pub reason: String,
}

/// The files that an expansion may read.
pub trait Files {
    /// The text of a file of at most `most_bytes`.
    ///
    /// # Errors
    /// A file that is not there, may not be read, is too large or is no UTF-8 text.
    fn read_text(&self, path: &Path, most_bytes: u64) -> Result<String, Unread>;

    /// The names in a folder, sorted, at most so many; none of a folder that may not be read.
    fn names_in(&self, folder: &Path, most: usize) -> Vec<String>;

    /// Whether there is a folder that may be read.
    fn is_folder(&self, path: &Path) -> bool;
}
