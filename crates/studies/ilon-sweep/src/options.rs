//! Options, progress and cancellation of a study.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::shard::Shard;
use ilon_sim::Error;

/// Progress of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Number of finished runs.
    pub done: u64,
    /// Number of these that were in the store before.
    pub found: u64,
    /// Number of these that failed.
    pub failed: u64,
    /// Expected number of runs; for a search the current estimate.
    pub likely: u64,
    /// Whether the total may differ from `likely`.
    pub is_search: bool,
}

/// Cancels a study from any thread that holds a copy: current runs end within a control period and
/// leave no row.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Requests the end.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the end was requested.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Returns [`Error::Stopped`] once the end was requested.
    pub(crate) fn check(&self) -> Result<(), Error> {
        match self.is_asked() {
            true => Err(Error::Stopped),
            false => Ok(()),
        }
    }
}

/// Options of a study.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Options {
    /// Number of parallel runs; by default the number of cores.
    pub jobs: Option<usize>,
    /// The part of the runs to make.
    pub shard: Option<Shard>,
    /// Cancels the study.
    pub stop: Stop,
}

impl Options {
    /// Options with a number of parallel runs, for a part of the study or all of it.
    pub fn new(jobs: Option<usize>, shard: Option<Shard>) -> Self {
        Self {
            jobs,
            shard,
            stop: Stop::default(),
        }
    }

    /// Adds a handle to cancel the study.
    pub fn stopped_by(mut self, stop: Stop) -> Self {
        self.stop = stop;
        self
    }

    /// Returns a pool with this number of threads.
    pub(crate) fn pool(&self) -> Result<rayon::ThreadPool, Error> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.jobs.unwrap_or(0))
            .build();
        pool.map_err(|error| {
            Error::invalid(format!("threads cannot be had: {error}"), "take fewer jobs")
        })
    }
}
