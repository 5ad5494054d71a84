//! Why a bag could not be written.

use std::io;
use std::path::{Path, PathBuf};

use crate::CdrError;

/// Why a bag could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BagError {
    /// A file or folder could not be made or written.
    #[error("could not write {path}: {source}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Another program writes this bag.
    #[error(
        "{path} is being written by another program; wait for its end, or choose another folder"
    )]
    Busy {
        /// The file of the bag.
        path: PathBuf,
    },
    /// A topic has a name that ROS 2 does not allow.
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
    /// A message was written to a topic that has not been declared, or for another type of message.
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
        /// Why.
        source: CdrError,
    },
    /// A time that rosbag2 cannot hold.
    #[error("the time {log_time_ns} ns of a message for {topic} does not fit into 63 bits")]
    Time {
        /// The name of the topic.
        topic: String,
        /// The time.
        log_time_ns: u64,
    },
    /// The MCAP file could not be written, for a reason other than the system's.
    #[error("could not write {path}: {reason}")]
    Mcap {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
}

impl BagError {
    /// What the system says about a path.
    pub(super) fn io(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        |source| Self::Io { path, source }
    }

    /// What the writer of MCAP says about a file.
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
