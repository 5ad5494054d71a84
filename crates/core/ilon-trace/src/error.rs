//! What can go wrong with traces and their files.

use std::io;
use std::path::PathBuf;

/// Why a trace or a file of it could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TraceError {
    /// The operating system refused.
    #[error("cannot {doing} `{}`: {source}", path.display())]
    Io {
        /// What was tried, such as `create`.
        doing: &'static str,
        /// On which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Another run writes there.
    #[error(
        "`{}` is being written to by another run{}",
        path.display(),
        holder.map_or_else(String::new, |process| format!(", process {process}"))
    )]
    InUse {
        /// The folder or file.
        path: PathBuf,
        /// The process that does, if it says so.
        holder: Option<u32>,
    },
    /// A folder that would be removed holds something that no run has written.
    #[error(
        "`{}` stands where a growing trace is kept, but no run has written it: move it elsewhere",
        path.display()
    )]
    Foreign {
        /// What it holds.
        path: PathBuf,
    },
    /// A recorded value is no number, or beyond all that means something.
    #[error("the simulation diverged at {t_s} s: `{signal}` is {value:e}")]
    Diverged {
        /// The signal, by its column's name.
        signal: String,
        /// When, in seconds.
        t_s: f64,
        /// Its value.
        value: f64,
    },
    /// The file holds other values than were written.
    #[error(
        "the trace `{}` is damaged or cut short: it does not hold what was written; run the scenario again",
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
        /// What the Parquet reader said.
        source: parquet::errors::ParquetError,
    },
    /// The file is Parquet, but no trace, or one that another program has written anew.
    #[error(
        "`{}` is a Parquet file, but no trace that ilon wrote",
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
    /// The header in the file's metadata cannot be understood.
    #[error("the header of the trace `{}` cannot be understood ({source}); it was written by another version: run the scenario again", path.display())]
    Header {
        /// The file.
        path: PathBuf,
        /// What the JSON reader said.
        source: serde_json::Error,
    },
    /// A column is not there, or is of another type.
    #[error("the trace `{}` has no column `{column}` of type {expected}; it was written by another version: run the scenario again", path.display())]
    Column {
        /// The file.
        path: PathBuf,
        /// The column's name.
        column: String,
        /// The physical type it should have.
        expected: &'static str,
    },
    /// The header names more tasks than a record holds.
    #[error(
        "the trace names {found} tasks, but a record holds at most {}",
        crate::MAX_TASKS
    )]
    TooManyTasks {
        /// How many it names.
        found: usize,
    },
    /// The trace could not be turned into Parquet.
    #[error("the trace could not be written to `{}`: {source}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What the Parquet writer said.
        source: parquet::errors::ParquetError,
    },
    /// What takes rows while a run is under way could not.
    #[error("the rows could not be handed to {sink}: {source}")]
    Sink {
        /// What took them.
        sink: String,
        /// Why it could not.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl TraceError {
    /// That a [`Sink`](crate::Sink) could not take rows, and why.
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
