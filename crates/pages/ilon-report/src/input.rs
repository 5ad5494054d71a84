//! What a report is made of.

use std::borrow::Cow;

use ilon_trace::rows::thinned;
use ilon_trace::{Rows, Trace};

use super::accumulate::Accumulated;

/// Rows that are drawn one by one, and what was gathered from all of them.
pub(super) struct RunInput<'t> {
    /// All rows of a run that lies in memory, evenly spread ones of one that does not.
    pub trace: Cow<'t, Trace>,
    /// It has one row in so many.
    pub every: usize,
    /// What all rows came to.
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

    /// At most `most` of many rows.
    pub fn of_many<R: Rows>(rows: &R, most: usize) -> Result<Self, R::Error> {
        let every = rows.row_count().div_ceil(most).max(1);
        Ok(Self {
            trace: Cow::Owned(thinned(rows, every)?),
            every,
            all: Accumulated::of(rows)?,
        })
    }
}
