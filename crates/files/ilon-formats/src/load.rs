//! Reads robots from files of all supported formats.

use std::path::Path;

use crate::diagnosis::{self, Diagnosis};
use crate::error::RobotError;
use crate::loaded::{self, Loaded};
use crate::model::Robot;
use crate::options::LoadOptions;

/// Functions to read robots, such as [`Robot::load`](LoadRobot::load), implemented only for
/// [`Robot`].
pub trait LoadRobot: Sized {
    /// Reads a robot from a file: URDF, xacro, SDF, MJCF, or a description in TOML.
    ///
    /// # Errors
    /// A file that cannot be read, has no supported format, or contains no omnidirectional robot
    /// that can be simulated: every [`Fault`](crate::Fault), with its place in the file.
    fn load(path: impl AsRef<Path>) -> Result<Self, RobotError>;

    /// Reads a robot from the text of a file; `file` is its name in errors, and the base of meshes
    /// and includes.
    ///
    /// # Errors
    /// Those of [`Self::load`], except for reading the file.
    fn from_urdf_str(text: &str, file: &str) -> Result<Self, RobotError>;

    /// Reads a robot from a file with options.
    ///
    /// # Errors
    /// Those of [`Self::load`], and options that do not fit the file.
    fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, RobotError>;

    /// Reads a robot from the text of a file with options.
    ///
    /// # Errors
    /// Those of [`Self::load_with`], except for reading the file.
    fn from_urdf_str_with(
        text: &str,
        file: &str,
        options: &LoadOptions,
    ) -> Result<Loaded, RobotError>;

    /// Finds all faults of a file that cannot be read with some options, and options with which it
    /// can. `works` returns whether a robot is usable. A readable file has no faults. The proposed
    /// options are minimal.
    fn diagnose(
        path: impl AsRef<Path>,
        options: &LoadOptions,
        works: impl Fn(&Self) -> bool,
    ) -> Diagnosis;
}

impl LoadRobot for Robot {
    fn load(path: impl AsRef<Path>) -> Result<Self, RobotError> {
        Self::load_with(path, &LoadOptions::default()).map(|loaded| loaded.robot)
    }

    fn from_urdf_str(text: &str, file: &str) -> Result<Self, RobotError> {
        Self::from_urdf_str_with(text, file, &LoadOptions::default()).map(|loaded| loaded.robot)
    }

    fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, RobotError> {
        loaded::read_file(path.as_ref(), options)
    }

    fn from_urdf_str_with(
        text: &str,
        file: &str,
        options: &LoadOptions,
    ) -> Result<Loaded, RobotError> {
        loaded::read_text(text, file, options)
    }

    fn diagnose(
        path: impl AsRef<Path>,
        options: &LoadOptions,
        works: impl Fn(&Robot) -> bool,
    ) -> Diagnosis {
        diagnosis::diagnose(path.as_ref(), options, works)
    }
}
