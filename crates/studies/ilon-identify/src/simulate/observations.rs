//! Measurements of all runs.

use crate::log::Log;
use crate::motion::{Tracker, Window};

/// Measurements of all runs.
pub(crate) struct Observations<'a> {
    pub windows: &'a [&'a Window],
    /// Whether each run is held out.
    pub held_out: &'a [bool],
    pub trackers: &'a [Tracker],
    pub logs: &'a [Log],
}
