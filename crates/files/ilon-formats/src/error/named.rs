//! What faults name: files that are missing, and joints that are no wheels.

use std::path::PathBuf;

/// A file that was looked for and not found.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingFile {
    /// The file, as it is written.
    pub what: String,
    /// The package that it lies in, where that package's folder is not known.
    pub package: Option<String>,
    /// The one folder around the robot's file that holds all files of that package which are missing, if there is one: the package may
    /// have been renamed.
    pub folder: Option<PathBuf>,
    /// Why it is not read, where it is there.
    pub reason: Option<String>,
    /// The file and line that name it.
    pub at: String,
}

/// A joint that was looked at for a wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct CandidateJoint {
    /// Its name.
    pub joint: String,
    /// Why it is none.
    pub reason: String,
    /// Whether it turns as a wheel does, and only stands too high for one.
    pub is_too_high: bool,
}
