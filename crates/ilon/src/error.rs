//! What can go wrong on the way from a scenario to its results, as a person reads it: what, where, and how to mend it.

use std::path::{Path, PathBuf};

use ilon_robot::RobotError;
use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

use crate::scenario;

/// Why there is no result. All of these are faults of the input or of the place to write to.
#[derive(Debug, Error, Diagnostic)]
pub enum Error {
    /// A file cannot be read.
    #[error("cannot read `{}`: {reason}", path.display())]
    #[diagnostic(help("check the path; it is taken from {}", from.display()))]
    Read {
        /// The file.
        path: PathBuf,
        /// Why, in the system's words.
        reason: String,
        /// The folder that a relative path is taken from.
        from: PathBuf,
    },

    /// A scenario is no TOML, or holds a key or value that it may not.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scenario(Box<ScenarioFault>),

    /// Keys that do not go together, or a value that this robot cannot take.
    #[error("{message}")]
    Invalid {
        /// What is wrong, with the keys.
        message: String,
        /// How to mend it.
        #[help]
        help: String,
    },

    /// A robot's file cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(Box<RobotFault>),

    /// The robot's wheels, or the reference, are such that it cannot be controlled.
    #[error("{0}")]
    #[diagnostic(help("{}", help_on_control(.0)))]
    Control(#[from] ilon_control::ControlError),

    /// The robot cannot be put into its world.
    #[error("{0}")]
    #[diagnostic(help("see `[world]` and `[robot]` of the scenario, and the robot's rollers"))]
    World(#[from] ilon_world::WorldError),

    /// A trace or another file of results cannot be written or read.
    #[error("{0}")]
    #[diagnostic(help("choose another place; nothing was left half-written"))]
    Trace(#[from] ilon_trace::TraceError),

    /// A file of waypoints holds something else than waypoints.
    #[error("{}: {message}", path.display())]
    #[diagnostic(help("{help}"))]
    Waypoints {
        /// The file.
        path: PathBuf,
        /// What is wrong, with its line.
        message: String,
        /// How to mend it.
        help: String,
    },

    /// Results cannot be written.
    #[error("cannot write `{}`: {reason}", path.display())]
    #[diagnostic(help("choose another place with --out; nothing was left half-written"))]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why, in the system's words.
        reason: String,
    },
}

/// A fault in a scenario's text, with its place.
#[derive(Debug, Error, Diagnostic)]
#[error("{message}")]
pub struct ScenarioFault {
    /// What is wrong.
    pub message: String,
    /// How to mend it.
    #[help]
    pub help: String,
    /// The text of the file, or of the `--set`.
    #[source_code]
    pub source_code: NamedSource<String>,
    /// Where in it.
    #[label("here")]
    pub span: SourceSpan,
}

/// A fault in a robot's file, with the lines at fault where they are known.
#[derive(Debug, Error, Diagnostic)]
#[error("{fault}")]
pub struct RobotFault {
    /// The fault.
    pub fault: RobotError,
    #[help]
    help: String,
    #[source_code]
    source_code: Option<NamedSource<String>>,
    #[label("here")]
    span: Option<SourceSpan>,
    /// What else is wrong with the file.
    #[related]
    pub others: Vec<RobotFault>,
}

impl RobotFault {
    fn new(fault: RobotError) -> Self {
        let text = fault.text().map(str::to_owned);
        Self {
            help: fault.help(),
            source_code: text.map(|text| NamedSource::new(fault.file(), text)),
            span: fault.place().map(|place| place.bytes.clone().into()),
            fault,
            others: Vec::new(),
        }
    }
}

impl From<RobotError> for Error {
    fn from(fault: RobotError) -> Self {
        let others = fault.others().to_vec();
        Self::of_robot(std::iter::once(fault).chain(others), &[])
    }
}

impl Error {
    /// Faults of a robot's file, and what would do about all of them.
    pub(crate) fn of_robot(
        faults: impl IntoIterator<Item = RobotError>,
        closing: &[String],
    ) -> Self {
        let mut faults = faults.into_iter().map(RobotFault::new);
        let Some(mut first) = faults.next() else {
            return Self::invalid("the robot's file cannot be used", "");
        };
        first.others = faults.collect();
        // What would do about all of them is said last.
        let last = first
            .others
            .last_mut()
            .map_or(&mut first.help, |last| &mut last.help);
        for line in closing {
            *last = format!("{last}; {line}");
        }
        Self::Robot(Box::new(first))
    }

    pub(crate) fn read(path: &Path, source: &std::io::Error) -> Self {
        Self::Read {
            path: path.to_owned(),
            reason: reason(source),
            from: std::env::current_dir().unwrap_or_default(),
        }
    }

    pub(crate) fn write(path: &Path, source: &std::io::Error) -> Self {
        Self::Write {
            path: path.to_owned(),
            reason: reason(source),
        }
    }

    pub(crate) fn invalid(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Invalid {
            message: message.into(),
            help: help.into(),
        }
    }

    pub(crate) fn toml(error: &toml::de::Error, source_code: NamedSource<String>) -> Self {
        Self::Scenario(Box::new(ScenarioFault {
            message: format!("not well-formed TOML: {}", error.message()),
            help: "the file is TOML: [section] lines, and `key = value` lines below them; `ilon schema` lists all keys"
                .to_owned(),
            source_code,
            span: scenario::toml_span(error),
        }))
    }
}

fn help_on_control(error: &ilon_control::ControlError) -> &'static str {
    use ilon_control::ControlError;
    match error {
        ControlError::TooFewWheels { .. }
        | ControlError::NoRollers { .. }
        | ControlError::NoControlAuthority { .. }
        | ControlError::Uncontrollable { .. } => {
            "`ilon inspect` shows the robot's wheels and the rows of M as they are understood"
        }
        _ => "change the number in the scenario or in the robot's file",
    }
}

/// The system's reason in plain words, without its error number.
fn reason(error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    match error.kind() {
        ErrorKind::NotFound => "there is no such file or folder".to_owned(),
        ErrorKind::PermissionDenied => "permission denied".to_owned(),
        ErrorKind::IsADirectory => "it is a folder".to_owned(),
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder".to_owned(),
        ErrorKind::AlreadyExists => "a file of that name stands in the way".to_owned(),
        ErrorKind::InvalidData => "it is not UTF-8 text".to_owned(),
        _ => error.to_string(),
    }
}
