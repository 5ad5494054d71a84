//! What was seen of all runs.

use crate::log::Log;
use crate::motion::{Tracker, Window};

/// What was seen of all runs.
pub(crate) struct Observations<'a> {
    pub windows: &'a [&'a Window],
    /// Of each run, whether it is kept back.
    pub held_out: &'a [bool],
    pub trackers: &'a [Tracker],
    pub logs: &'a [Log],
}
