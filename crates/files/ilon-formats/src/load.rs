//! Reads robots from files, whatever they are written in.

use std::path::Path;

use crate::diagnosis::{self, Diagnosis};
use crate::error::RobotError;
use crate::loaded::{self, Loaded};
use crate::model::Robot;
use crate::options::LoadOptions;

/// Reads robots: [`Robot::load`](LoadRobot::load) and what goes with it, for [`Robot`] alone.
pub trait LoadRobot: Sized {
    /// Reads a robot from a file: URDF, xacro, SDF, MJCF, or a description in TOML.
    ///
    /// # Errors
    /// A file that cannot be read, that is none of these, or whose robot is not an omnidirectional one that can be simulated:
    /// every [`Fault`](crate::Fault), with its place in the file.
    fn load(path: impl AsRef<Path>) -> Result<Self, RobotError>;

    /// Reads a robot from the text of a file; `file` is what errors call it, and meshes and includes are sought beside it.
    ///
    /// # Errors
    /// As [`Self::load`], but for reading the file.
    fn from_urdf_str(text: &str, file: &str) -> Result<Self, RobotError>;

    /// Reads a robot from a file as the options say.
    ///
    /// # Errors
    /// As [`Self::load`], and options that do not fit the file.
    fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, RobotError>;

    /// Reads a robot from the text of a file as the options say.
    ///
    /// # Errors
    /// As [`Self::load_with`], but for reading the file.
    fn from_urdf_str_with(
        text: &str,
        file: &str,
        options: &LoadOptions,
    ) -> Result<Loaded, RobotError>;

    /// Looks for everything that is wrong with a file that cannot be read with some options, and for options with which it can.
    /// `works` says whether a robot that could be read is of use. Of a file that can be read, there are no faults. Of the options
    /// that are proposed, none can be left out.
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
