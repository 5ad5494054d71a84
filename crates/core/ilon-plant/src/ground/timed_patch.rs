//! A patch of the floor with a time window.

use ilon_world::Patch;

use ilon_scenario::scenario;

/// A patch and its time window.
#[derive(Clone, Debug)]
pub(crate) struct TimedPatch {
    pub patch: Patch,
    pub from_s: f64,
    pub until_s: Option<f64>,
}

impl TimedPatch {
    /// When it appears, and when it disappears, if it does; in seconds.
    pub fn window_s(&self) -> (f64, Option<f64>) {
        (self.from_s, self.until_s)
    }

    /// The patches present at a time in seconds.
    pub fn those_at(all: &[Self], t_s: f64) -> Vec<Patch> {
        let there = |timed: &&Self| scenario::within(t_s, timed.from_s, timed.until_s);
        let patches = all.iter().filter(there);
        patches.map(|timed| timed.patch.clone()).collect()
    }
}
