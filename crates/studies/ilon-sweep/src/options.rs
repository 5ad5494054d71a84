//! How a study is run, how far it is, and how it is stopped.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::shard::Shard;
use ilon_sim::Error;

/// How far a study is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Runs that there are.
    pub done: u64,
    /// Of these, those that were there before.
    pub found: u64,
    /// Those of them that failed.
    pub failed: u64,
    /// How many there will be; of a search as far as is known.
    pub likely: u64,
    /// Whether there may be fewer or more than that.
    pub is_search: bool,
}

/// Asks a study to end early, from whichever thread holds a copy: runs under way end within a control period and leave no row.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Asks for it.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked for.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// [`Error::Stopped`] once it was asked for.
    pub(crate) fn check(&self) -> Result<(), Error> {
        match self.is_asked() {
            true => Err(Error::Stopped),
            false => Ok(()),
        }
    }
}

/// How a study is run.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Options {
    /// Runs at a time; left out, as many as the machine has cores.
    pub jobs: Option<usize>,
    /// Which part of the runs is made.
    pub shard: Option<Shard>,
    /// What ends it early.
    pub stop: Stop,
}

impl Options {
    /// So many runs at a time, of a part of the study or of all of it.
    pub fn new(jobs: Option<usize>, shard: Option<Shard>) -> Self {
        Self {
            jobs,
            shard,
            stop: Stop::default(),
        }
    }

    /// Ended early by `stop`.
    pub fn stopped_by(mut self, stop: Stop) -> Self {
        self.stop = stop;
        self
    }

    /// The threads that it asks for.
    pub(crate) fn pool(&self) -> Result<rayon::ThreadPool, Error> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.jobs.unwrap_or(0))
            .build();
        pool.map_err(|error| {
            Error::invalid(format!("threads cannot be had: {error}"), "take fewer jobs")
        })
    }
}
