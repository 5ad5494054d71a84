//! Errors between a scenario and its results, as shown to a person: what, where, and how to repair
//! it.

use std::path::{Path, PathBuf};

use ilon_files::ReadError;
use ilon_formats::RobotError;
use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

/// Why there is no result.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read, or access is not permitted.
    #[error("cannot read `{}`: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
        /// How to repair it.
        #[help]
        help: String,
    },

    /// A scenario is not valid TOML, or has an invalid key or value.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scenario(Box<ScenarioFault>),

    /// Keys that contradict each other, or a value that this robot cannot take.
    #[error("{message}")]
    Invalid {
        /// The fault, with its keys.
        message: String,
        /// How to repair it.
        #[help]
        help: String,
    },

    /// Something cannot be encoded as the text of a file.
    #[error("{what} cannot be written as text: {reason}")]
    #[diagnostic(help("this is a fault of ilon itself: please report it"))]
    Encode {
        /// What should be written.
        what: &'static str,
        /// The writer's error.
        reason: String,
    },

    /// A robot's file cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(Box<RobotFault>),

    /// The robot's wheels or the reference make control impossible.
    #[error("{0}")]
    #[diagnostic(help("{}", help_on_control(.0)))]
    Control(#[from] ilon_control::ControlError),

    /// The robot cannot be placed in its world.
    #[error("{0}")]
    #[diagnostic(help("see `[world]` and `[robot]` of the scenario, and the robot's rollers"))]
    World(#[from] ilon_world::WorldError),

    /// A trace or another file of results cannot be written or read.
    #[error("{0}")]
    #[diagnostic(help("{}", help_on_trace(.0)))]
    Trace(#[from] ilon_trace::TraceError),

    /// The robot's motion has become NaN or infinite.
    #[error("the simulation diverged before {t_s} s: the robot's motion is not finite")]
    #[diagnostic(help(
        "look for numbers of very different size in the scenario, the robot's file and the commands, or take shorter steps: \
         `run.physics_dt_s`"
    ))]
    Diverged {
        /// The time when it was detected, in seconds.
        t_s: f64,
    },

    /// The run was stopped before its end.
    #[error("it was stopped before its end")]
    #[diagnostic(help("start it again: finished runs are kept"))]
    Stopped,

    /// A file that was named as a log, height map or list of waypoints has another content.
    #[error("{}: {message}", path.display())]
    #[diagnostic(help("{help}"))]
    Contents {
        /// The file.
        path: PathBuf,
        /// The fault, with its place.
        message: String,
        /// How to repair it.
        help: String,
    },
}

/// A fault in a scenario's text, with its place.
#[derive(Debug, Error, Diagnostic)]
#[error("{message}")]
pub struct ScenarioFault {
    /// What is wrong.
    pub message: String,
    /// How to repair it.
    #[help]
    pub help: String,
    /// The text of the file, or of the setting.
    #[source_code]
    pub source_code: NamedSource<String>,
    /// The place in it.
    #[label("here")]
    pub span: SourceSpan,
    /// The other faults of the same text.
    #[related]
    pub related: Vec<ScenarioFault>,
}

impl ScenarioFault {
    /// A fault without others, in a text at a place.
    pub fn new(
        message: impl Into<String>,
        help: impl Into<String>,
        (source_code, span): (NamedSource<String>, SourceSpan),
    ) -> Self {
        Self {
            message: message.into(),
            help: help.into(),
            source_code,
            span,
            related: Vec::new(),
        }
    }
}

impl From<ScenarioFault> for Error {
    fn from(fault: ScenarioFault) -> Self {
        Self::Scenario(Box::new(fault))
    }
}

/// A fault in a robot's file, with its lines if they are known.
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
    /// The other faults of the file.
    #[related]
    pub others: Vec<RobotFault>,
}

impl RobotFault {
    fn new(fault: RobotError) -> Self {
        // Nothing is shown of a file that is not a robot: an untrusted scenario may name any file.
        let is_robot = |text: &&str| match fault.file().ends_with(".toml") {
            true => text.contains("wheel"),
            false => ["<robot", "<sdf", "<mujoco"]
                .iter()
                .any(|tag| text.contains(tag)),
        };
        let text = fault.text().filter(is_robot).map(str::to_owned);
        Self {
            help: fault.help(),
            source_code: text.map(|text| NamedSource::new(fault.file(), text)),
            span: fault.place().map(|place| place.bytes.clone().into()),
            fault,
            others: Vec::new(),
        }
    }

    /// The same fault, with the lines of the text that names the cause instead of the robot's
    /// lines.
    pub(crate) fn placed(self, text: NamedSource<String>, span: std::ops::Range<usize>) -> Self {
        Self {
            source_code: Some(text),
            span: Some(span.into()),
            ..self
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
    /// The faults of a robot's file, and a remedy for all of them.
    pub fn of_robot(faults: impl IntoIterator<Item = RobotError>, closing: &[String]) -> Self {
        let mut faults = RobotError::by_place(faults)
            .into_iter()
            .map(RobotFault::new);
        let Some(mut first) = faults.next() else {
            return Self::invalid("the robot's file cannot be used", "");
        };
        first.others = faults.collect();
        // The remedy for all comes with the first fault, because nobody reads to the last of
        // dozens.
        for line in closing {
            first.help = format!("{}; {line}", first.help);
        }
        Self::Robot(Box::new(first))
    }

    /// A file that cannot be read.
    pub fn read(path: &Path, fault: &ReadError) -> Self {
        let from = std::env::current_dir().unwrap_or_default();
        let (reason, help) = match fault {
            ReadError::Io(source) => (
                reason(source),
                format!("check the path; it is taken from {}", from.display()),
            ),
            ReadError::Outside(_) => (
                fault.to_string(),
                "move it there, or allow its folder too (links are resolved first)".to_owned(),
            ),
            _ => (fault.to_string(), "name a file of text".to_owned()),
        };
        Self::Read {
            path: path.to_owned(),
            reason,
            help,
        }
    }

    /// A fault in a file, and how to repair it.
    pub fn contents(path: &Path, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Contents {
            path: path.to_owned(),
            message: message.into(),
            help: help.into(),
        }
    }

    /// A system error of an operation ("read", "write", "create") on a file or folder.
    pub fn io(doing: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| {
            Self::Trace(ilon_trace::TraceError::Io {
                doing,
                path,
                source,
            })
        }
    }

    /// A fault, and how to repair it.
    pub fn invalid(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Invalid {
            message: message.into(),
            help: help.into(),
        }
    }

    /// Something that cannot be encoded, and the reason.
    pub fn encode(what: &'static str, reason: &dyn std::fmt::Display) -> Self {
        Self::Encode {
            what,
            reason: reason.to_string(),
        }
    }

    pub(crate) fn toml(error: &toml::de::Error, source_code: NamedSource<String>) -> Self {
        let said = error.message();
        let bytes = source_code.inner().as_bytes();
        let is_digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
        let is_comma = error.span().is_some_and(|span| {
            let at = span.start;
            bytes.get(at) == Some(&b',') && at > 0 && is_digit(at - 1) && is_digit(at + 1)
        });
        let help = match said {
            said if said.contains("must be quoted") => {
                "write a value: text in straight quotes, `\"so\"`; a number with a point and without its unit, `0.5`"
            }
            _ if is_comma => "a number has a point, not a comma: `0.3`",
            _ if said.contains("mantissa") => "a number begins with a digit: `0.3`",
            "duplicate key" => "it is set above already: keep one of the two",
            _ => {
                "the file is TOML: [section] lines, and `key = value` lines below them; `ilon schema` lists all keys"
            }
        };
        let message = format!("not well-formed TOML: {said}");
        ScenarioFault::new(message, help, (source_code, toml_span(error))).into()
    }

    /// Valid TOML with an unsuitable content, with message and place.
    pub(crate) fn toml_value(
        message: &str,
        source_code: NamedSource<String>,
        span: SourceSpan,
    ) -> Self {
        let missing = message.strip_prefix("missing field ");
        let (message, help) = match missing {
            Some(key) => (
                format!("the key {key} is missing"),
                "add it; `ilon schema` lists all keys",
            ),
            None => (
                message.to_owned(),
                "correct the value; `ilon schema` lists what each key takes",
            ),
        };
        ScenarioFault::new(message, help, (source_code, span)).into()
    }
}

/// The place of a TOML error, or the whole text if it has none.
pub(crate) fn toml_span(error: &toml::de::Error) -> SourceSpan {
    match error.span() {
        Some(span) => span.into(),
        None => SourceSpan::from(0..0),
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
        ControlError::NoTasks | ControlError::TwiceATask { .. } => {
            "correct the list `guidance.tasks`, or leave it out for the default"
        }
        _ => "change the number in the scenario or in the robot's file",
    }
}

fn help_on_trace(error: &ilon_trace::TraceError) -> &'static str {
    use ilon_trace::TraceError;
    match error {
        TraceError::InUse { .. } => "wait until it ends, or write elsewhere",
        TraceError::Foreign { .. } => {
            "nothing of it was removed; write to another folder, or move it away"
        }
        TraceError::Diverged { .. } => {
            "look for numbers of very different size in the scenario and in the robot's file, or take shorter steps: \
             `run.physics_dt_s`"
        }
        TraceError::Sink { .. } => "repair the consumer of the rows, or run without it",
        TraceError::Io { doing: "read", .. } => "check the path, and that it may be read",
        TraceError::Io { .. } | TraceError::Encode { .. } => {
            "make room, or choose another place; no file is left half-written under its name"
        }
        _ => "name a trace that this version of ilon wrote",
    }
}

/// The system's reason without its error number.
pub fn reason(error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    match error.kind() {
        ErrorKind::NotFound => "there is no such file or folder".to_owned(),
        ErrorKind::PermissionDenied => "permission denied".to_owned(),
        ErrorKind::IsADirectory => "it is a folder".to_owned(),
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder".to_owned(),
        ErrorKind::ReadOnlyFilesystem => "its file system cannot be written to".to_owned(),
        ErrorKind::StorageFull => "the disk is full".to_owned(),
        ErrorKind::AlreadyExists => "a file of that name stands in the way".to_owned(),
        _ => error.to_string(),
    }
}
