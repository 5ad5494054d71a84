//! The interface of displays.

use crate::control::Controls;
use crate::session::{Row, Session};

/// Status of a live run.
#[derive(Clone, Copy, Debug)]
pub struct Status<'a> {
    /// The current commands.
    pub controls: &'a Controls,
    /// Simulated seconds per elapsed second.
    pub real_time_factor: f64,
}

/// A display of a live run. It must drop what it cannot process at once: the simulation never
/// waits.
pub trait Observer {
    /// Called after each control period.
    fn row(&mut self, _row: Row<'_>) {}

    /// Called in every round of the loop, at least fifty times per second, even while time stands.
    fn look(&mut self, _session: &Session, _status: Status<'_>) {}

    /// Called when the robot is back at its start.
    fn restarted(&mut self, _session: &Session) {}

    /// Receives a note.
    fn say(&mut self, _note: &str) {}
}
