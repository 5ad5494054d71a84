//! What faults name: missing files, joints that are no wheels, rollers that a file suggests.

use std::path::PathBuf;

use crate::options::WheelOptions;

/// A missing file.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingFile {
    /// The file, as written.
    pub what: String,
    /// Its package, if that package's folder is unknown.
    pub package: Option<String>,
    /// The only folder around the robot's file that contains all missing files of that package, if
    /// there is one: the package may have been renamed.
    pub folder: Option<PathBuf>,
    /// The reason, if the file exists but cannot be read.
    pub reason: Option<String>,
    /// The file and line that name it.
    pub at: String,
}

/// A joint considered as a wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct CandidateJoint {
    /// Its name.
    pub joint: String,
    /// Why it is no wheel.
    pub reason: String,
    /// Whether it turns like a wheel, and is only too high.
    pub is_too_high: bool,
}

/// Rollers suggested by a file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Proposed {
    /// Rollers that match the wheels' arrangement and names.
    Rollers(Box<WheelOptions>),
    /// The wheels' names contradict their arrangement.
    Contradiction,
    /// Nothing suggests rollers: they may be plain wheels.
    NothingSaid,
}
