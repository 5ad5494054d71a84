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
    /// Another program is writing this bag.
    #[error(
        "{path} is being written by another program; wait for its end, or choose another folder"
    )]
    Busy {
        /// The file of the bag.
        path: PathBuf,
    },
    /// ROS 2 does not allow the topic's name.
    #[error(
        "\"{topic}\" cannot be the name of a topic: it takes a slash before each part, and in each part letters, digits and \
         underscores, with no digit first, and at most {max} characters in all",
        max = super::topic::MAX_LENGTH
    )]
    TopicName {
        /// The name.
        topic: String,
    },
    /// A topic was declared twice.
    #[error("the topic {topic} has been declared already")]
    DeclaredTwice {
        /// Its name.
        topic: String,
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
    /// A time outside rosbag2's range.
    #[error("the time {log_time_ns} ns of a message for {topic} does not fit into 63 bits")]
    Time {
        /// The name of the topic.
        topic: String,
        /// The time.
        log_time_ns: u64,
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
