//! Errors of writing a bag.

use std::io;
use std::path::{Path, PathBuf};

use crate::CdrError;

/// Reasons why a bag could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BagError {
    /// A file or folder could not be created or written.
    #[error("could not write {path}: {source}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A message was written to an undeclared topic, or to a topic of another type.
    #[error("the topic {topic} has not been declared for {type_name}")]
    NotDeclared {
        /// The name of the topic.
        topic: String,
        /// The type of the message.
        type_name: &'static str,
    },
    /// A message cannot be encoded.
    #[error("a message for {topic} cannot be encoded: {source}")]
    Message {
        /// The name of the topic.
        topic: String,
        /// The reason.
        source: CdrError,
    },
    /// The MCAP file could not be written, without an error of the system.
    #[error("could not write {path}: {reason}")]
    Mcap {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
}

impl BagError {
    /// Converts a system error about a path.
    pub(super) fn io(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        |source| Self::Io { path, source }
    }

    /// Converts an error of the MCAP writer about a file.
    pub(super) fn mcap(path: &Path) -> impl FnOnce(mcap::McapError) -> Self {
        let path = path.to_owned();
        |error| match error {
            mcap::McapError::Io(source) => Self::Io { path, source },
            other => Self::Mcap {
                path,
                reason: other.to_string(),
            },
        }
    }
}
