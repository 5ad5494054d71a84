//! The input of a report.

use std::borrow::Cow;

use ilon_trace::rows::thinned;
use ilon_trace::{Rows, Trace};

use super::accumulate::Accumulated;

/// The rows to draw one by one, and the data collected from all rows.
pub(super) struct RunInput<'t> {
    /// All rows of a run in memory, otherwise evenly spaced ones.
    pub trace: Cow<'t, Trace>,
    /// Spacing of these rows.
    pub every: usize,
    /// Data collected from all rows.
    pub all: Accumulated,
}

impl<'t> RunInput<'t> {
    /// All rows of a trace.
    pub fn of(trace: &'t Trace) -> Result<Self, std::convert::Infallible> {
        Ok(Self {
            trace: Cow::Borrowed(trace),
            every: 1,
            all: Accumulated::of(trace)?,
        })
    }

    /// At most `most` of all rows.
    pub fn of_many<R: Rows>(rows: &R, most: usize) -> Result<Self, R::Error> {
        let every = rows.row_count().div_ceil(most).max(1);
        Ok(Self {
            trace: Cow::Owned(thinned(rows, every)?),
            every,
            all: Accumulated::of(rows)?,
        })
    }
}
