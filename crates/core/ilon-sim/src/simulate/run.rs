//! A finished run, and how far one is.

use ilon_trace::{Summary, Trace};

use crate::scenario::Scenario;

/// A finished run, with its trace in memory or, of a run of any length, as it was [`Recorded`](ilon_trace::Recorded).
#[derive(Clone, Debug)]
pub struct Run<T = Trace> {
    /// The scenario as it was run: every default and everything chosen by the program spelled out.
    pub scenario: Scenario,
    /// What was recorded.
    pub trace: T,
    /// The figures of the run.
    pub summary: Summary,
    /// What a person should know about the input, although it could be run.
    pub warnings: Vec<String>,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Simulated time, in seconds.
    pub time_s: f64,
    /// Simulated time at the end of the run, in seconds.
    pub duration_s: f64,
}
