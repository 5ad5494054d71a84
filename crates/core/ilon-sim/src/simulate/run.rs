//! A finished run, and the progress of an unfinished one.

use ilon_trace::{Summary, Trace};

use crate::scenario::Scenario;

/// A finished run. Its trace is in memory, or, for a run of any length,
/// [`Recorded`](ilon_trace::Recorded).
#[derive(Clone, Debug)]
pub struct Run<T = Trace> {
    /// The scenario as it was run, with every default and every choice of the program written out.
    pub scenario: Scenario,
    /// What was recorded.
    pub trace: T,
    /// The figures of the run.
    pub summary: Summary,
    /// Warnings about the input, although it could be run.
    pub warnings: Vec<String>,
}

/// The progress of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Simulated time, in seconds.
    pub time_s: f64,
    /// Simulated time at the end of the run, in seconds.
    pub duration_s: f64,
}
