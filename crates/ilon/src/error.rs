//! What can go wrong on the way from a scenario to its results, as a person reads it: what, where, and how to mend it.

use std::path::{Path, PathBuf};

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
    #[error("{message}")]
    Scenario {
        /// What is wrong.
        message: String,
        /// How to mend it.
        #[help]
        help: String,
        /// The text of the file, or of the `--set`.
        #[source_code]
        source_code: NamedSource<String>,
        /// Where in it.
        #[label("here")]
        span: SourceSpan,
    },

    /// Keys that do not go together, or a value that this robot cannot take.
    #[error("{message}")]
    Invalid {
        /// What is wrong, with the keys.
        message: String,
        /// How to mend it.
        #[help]
        help: String,
    },

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

impl Error {
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
        Self::Scenario {
            message: format!("not a scenario: {}", error.message()),
            help: "the file is TOML: [section] lines, and `key = value` lines below them; `ilon schema` lists all keys"
                .to_owned(),
            source_code,
            span: scenario::toml_span(error),
        }
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
