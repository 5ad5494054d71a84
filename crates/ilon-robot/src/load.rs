//! Reads robots from files, whatever they are written in.

use std::path::Path;
use std::sync::Arc;

use crate::error::RobotError;
use crate::model::Robot;
use crate::options::{LoadOptions, WheelOptions};
use crate::prepare::{prepare, read_text};
use crate::urdf::{self, Prepared, Read, WheelOutline};

/// Most rounds of repair: what one round leaves, the next may show.
const MOST_ROUNDS: usize = 8;
/// Most options that are tried, one upon the other, to find some that work.
const MOST_TRIES: usize = 8;

/// A robot as it was read, and how well its file models it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Loaded {
    /// The robot.
    pub robot: Robot,
    /// The outline of each wheel as the file models it; of wheels that were given rollers there is none.
    pub outlines: Vec<WheelOutline>,
    /// The rollers that wheels without any were given because of what the file says of them.
    pub inferred: Option<WheelOptions>,
    /// The URDF that was read: the file's own text, or what it was expanded or converted to, with everything repaired.
    pub urdf: Arc<str>,
}

/// Why a file cannot be read as it is, and what would do.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Diagnosis {
    /// All faults that were found, those too that show only once others are out of the way.
    pub faults: Vec<RobotError>,
    /// Options with which the file was read, where any were found.
    pub proposal: Option<LoadOptions>,
    /// What was read with them.
    pub loaded: Option<Box<Loaded>>,
}

impl Robot {
    /// Reads a robot from a file: URDF, xacro, SDF, MJCF, or a description in TOML.
    ///
    /// # Errors
    /// A file that cannot be read, that is none of these, or whose robot is not an omnidirectional one that can be simulated:
    /// every [`Fault`], with its place in the file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, RobotError> {
        Self::load_with(path, &LoadOptions::default()).map(|loaded| loaded.robot)
    }

    /// Reads a robot from the text of a file; `file` is what errors call it, and meshes and includes are sought beside it.
    ///
    /// # Errors
    /// As [`Robot::load`], but for reading the file.
    pub fn from_urdf_str(text: &str, file: &str) -> Result<Self, RobotError> {
        Self::from_urdf_str_with(text, file, &LoadOptions::default()).map(|loaded| loaded.robot)
    }

    /// Reads a robot from a file as the options say.
    ///
    /// # Errors
    /// As [`Robot::load`], and options that do not fit the file.
    pub fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, RobotError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text = read_text(path, &file, options)?;
        Self::from_urdf_str_with(&text, &file, options)
    }

    /// Reads a robot from the text of a file as the options say.
    ///
    /// # Errors
    /// As [`Robot::load_with`], but for reading the file.
    pub fn from_urdf_str_with(
        text: &str,
        file: &str,
        options: &LoadOptions,
    ) -> Result<Loaded, RobotError> {
        let mut prepared = prepare(text, file, options)?;
        let mut rounds = 0;
        loop {
            rounds += 1;
            let may_repair = options.repair && rounds <= MOST_ROUNDS;
            let repaired = match urdf::read(&prepared, options) {
                Ok(read) => {
                    let level = may_repair.then(|| urdf::levelled(&prepared, &read.robot));
                    match level.flatten() {
                        Some(level) => level,
                        None => return Ok(loaded(read, &prepared)),
                    }
                }
                Err(error) => {
                    let repaired = may_repair.then(|| urdf::repaired(&prepared, &error, options));
                    repaired.flatten().ok_or(error)?
                }
            };
            prepared = repaired;
        }
    }

    /// Looks for everything that is wrong with a file that cannot be read with some options, and for options with which it can.
    /// `works` says whether a robot that could be read is of use. Of a file that can be read, there are no faults.
    pub fn diagnose(
        path: impl AsRef<Path>,
        options: &LoadOptions,
        works: impl Fn(&Robot) -> bool,
    ) -> Diagnosis {
        let mut diagnosis = Diagnosis {
            faults: Vec::new(),
            proposal: None,
            loaded: None,
        };
        let mut tried = options.clone();
        for _ in 0..MOST_TRIES {
            let error = match Self::load_with(&path, &tried) {
                Ok(loaded) => {
                    if works(&loaded.robot) {
                        diagnosis.proposal = (tried != *options).then_some(tried);
                        diagnosis.loaded = Some(Box::new(loaded));
                    }
                    return diagnosis;
                }
                Err(error) => error,
            };
            let all = || std::iter::once(&error).chain(error.others());
            let new: Vec<RobotError> = all()
                .filter(|e| {
                    !diagnosis
                        .faults
                        .iter()
                        .any(|known| known.to_string() == e.to_string())
                })
                .cloned()
                .collect();
            diagnosis.faults.extend(new);
            let next = all()
                .flat_map(RobotError::remedies)
                .find_map(|remedy| remedy.apply(&tried));
            match next {
                Some(next) => tried = next,
                None => return diagnosis,
            }
        }
        diagnosis
    }
}

fn loaded(read: Read, prepared: &Prepared) -> Loaded {
    let Read {
        robot,
        outlines,
        inferred,
    } = read;
    Loaded {
        robot,
        outlines,
        inferred,
        urdf: Arc::clone(&prepared.text),
    }
}
