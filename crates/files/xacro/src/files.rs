//! File access of an expansion.

use std::path::Path;

/// The reason why a file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct Unread {
    /// Whether the file is missing, which an expansion may ignore.
    pub is_missing: bool,
    /// The reason as text.
    pub reason: String,
}

/// The files accessible to an expansion.
pub trait Files {
    /// Returns the text of a file of at most `most_bytes`.
    ///
    /// # Errors
    /// A file that is missing, inaccessible, too large or not UTF-8.
    fn read_text(&self, path: &Path, most_bytes: u64) -> Result<String, Unread>;

    /// Returns the names in a folder, sorted, at most `most`; empty for an inaccessible folder.
    fn names_in(&self, folder: &Path, most: usize) -> Vec<String>;

    /// Whether an accessible folder exists.
    fn is_folder(&self, path: &Path) -> bool;
}
