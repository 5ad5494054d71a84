//! Errors of traces and their files.

use std::io;
use std::path::PathBuf;

/// Why a trace or its file could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TraceError {
    /// The operating system refused.
    #[error("cannot {doing} `{}`: {source}", path.display())]
    Io {
        /// The operation, such as `create`.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Another run is writing there.
    #[error(
        "`{}` is being written to by another run{}",
        path.display(),
        holder.map_or_else(String::new, |process| format!(", process {process}"))
    )]
    InUse {
        /// The folder or file.
        path: PathBuf,
        /// The id of that process, if it is known.
        holder: Option<u32>,
    },
    /// A folder that would be removed contains something that no run has written.
    #[error(
        "`{}` is in the place of a growing trace, but no run has written it: move it elsewhere",
        path.display()
    )]
    Foreign {
        /// The foreign entry.
        path: PathBuf,
    },
    /// A recorded value is NaN, infinite or beyond any meaningful size.
    #[error("the simulation diverged at {t_s} s: `{signal}` is {value:e}")]
    Diverged {
        /// The signal, by its column's name.
        signal: String,
        /// Its time, in seconds.
        t_s: f64,
        /// Its value.
        value: f64,
    },
    /// The file's content is not what was written.
    #[error(
        "the trace `{}` is damaged or cut short: its checksum is wrong; run the scenario again",
        path.display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
    },
    /// The file is not Parquet, or broken.
    #[error(
        "`{}` cannot be read as Parquet ({source}); was it cut short, or is it another kind of file?",
        path.display()
    )]
    NotParquet {
        /// The file.
        path: PathBuf,
        /// The Parquet reader's error.
        source: parquet::errors::ParquetError,
    },
    /// The file is Parquet but not a trace, or was rewritten by another program.
    #[error(
        "`{}` is a Parquet file, but not a trace of ilon",
        path.display()
    )]
    NotATrace {
        /// The file.
        path: PathBuf,
    },
    /// The folder holds no part of a trace.
    #[error(
        "the folder `{}` holds no part of a trace; a run writes them there while it goes on, and removes them once the whole trace is written",
        path.display()
    )]
    NoParts {
        /// The folder.
        path: PathBuf,
    },
    /// The header in the file's metadata is invalid.
    #[error("the header of the trace `{}` cannot be understood ({source}); it was written by another version: run the scenario again", path.display())]
    Header {
        /// The file.
        path: PathBuf,
        /// The JSON reader's error.
        source: serde_json::Error,
    },
    /// A column is missing or has another type.
    #[error("the trace `{}` has no column `{column}` of type {expected}; it was written by another version: run the scenario again", path.display())]
    Column {
        /// The file.
        path: PathBuf,
        /// The column's name.
        column: String,
        /// The expected physical type.
        expected: &'static str,
    },
    /// The header names more tasks than a record can hold.
    #[error(
        "the trace names {found} tasks, but a record holds at most {}",
        crate::MAX_TASKS
    )]
    TooManyTasks {
        /// The number of tasks.
        found: usize,
    },
    /// The trace could not be encoded as Parquet.
    #[error("the trace could not be written to `{}`: {source}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// The Parquet writer's error.
        source: parquet::errors::ParquetError,
    },
    /// A sink failed while a run was in progress.
    #[error("the rows could not be handed to {sink}: {source}")]
    Sink {
        /// The sink.
        sink: String,
        /// Its error.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl TraceError {
    /// An error of a [`Sink`](crate::Sink) that could not take rows.
    pub fn sink(
        sink: impl Into<String>,
        source: impl Into<Box<dyn std::error::Error + Send + Sync>>,
    ) -> Self {
        Self::Sink {
            sink: sink.into(),
            source: source.into(),
        }
    }
}
