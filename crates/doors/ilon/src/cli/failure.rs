//! Why a command fails.

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use thiserror::Error;

/// Why a command fails: an error in the input, in the arguments, or in writing.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum Failure {
    /// An error of the simulation library about a scenario, a robot or a trace.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Simulation(ilon_sim::Error),

    /// The arguments ask for something that cannot be done, whatever the files contain.
    #[error("{message}")]
    Usage {
        /// What is wrong, with the option or path.
        message: String,
        /// What to pass instead.
        #[help]
        help: String,
    },

    /// A panic in ilon. If several scenarios run, the others continue.
    #[error("ilon broke down over this scenario; what it said stands on standard error")]
    #[diagnostic(help("this is a fault of ilon itself: please report it, with the scenario"))]
    BrokeDown,

    /// Results cannot be written.
    #[error("cannot write `{}`: {reason}", path.display())]
    #[diagnostic(help("choose another place with --out; nothing was left half-written"))]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The reason given by the system.
        reason: String,
    },
}

impl Failure {
    pub(super) fn usage(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Usage {
            message: message.into(),
            help: help.into(),
        }
    }

    pub(super) fn encode(what: &'static str, reason: &dyn std::fmt::Display) -> Self {
        Self::Simulation(ilon_sim::Error::encode(what, reason))
    }

    pub(super) fn write(path: &Path, source: &std::io::Error) -> Self {
        Self::Write {
            path: path.to_owned(),
            reason: ilon_sim::reason(source),
        }
    }

    /// A file or folder cannot be read.
    pub(super) fn read(path: &Path, source: std::io::Error) -> Self {
        ilon_sim::Error::read(path, &ilon_files::ReadError::Io(source)).into()
    }
}

impl<E: Into<ilon_sim::Error> + KnownToSimulation> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Simulation(error.into())
    }
}

/// Errors that [`ilon_sim::Error`] wraps.
pub(super) trait KnownToSimulation {}
impl KnownToSimulation for ilon_sim::Error {}
impl KnownToSimulation for ilon_formats::RobotError {}
impl KnownToSimulation for ilon_control::ControlError {}
impl KnownToSimulation for ilon_world::WorldError {}
impl KnownToSimulation for ilon_trace::TraceError {}
