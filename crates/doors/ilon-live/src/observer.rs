//! Who looks on.

use crate::control::Controls;
use crate::session::{Row, Session};

/// How a live run goes.
#[derive(Clone, Copy, Debug)]
pub struct Status<'a> {
    /// What was said last.
    pub controls: &'a Controls,
    /// Simulated seconds in each second that passes.
    pub real_time_factor: f64,
}

/// Somebody who is shown a live run. Whoever cannot take something at once lets it go: the simulation waits for nobody.
pub trait Observer {
    /// A control period has passed.
    fn row(&mut self, _row: Row<'_>) {}

    /// Comes in every round of the loop, at least fifty times a second, while time stands too.
    fn look(&mut self, _session: &Session, _status: Status<'_>) {}

    /// The robot is back at its start.
    fn restarted(&mut self, _session: &Session) {}

    /// There is something to say.
    fn say(&mut self, _note: &str) {}
}
