//! What is there for a time: a patch of the floor, a payload, a fault.

use ilon_scenario::scenario::within;

/// A thing and its time window.
#[derive(Clone, Debug)]
pub(crate) struct Timed<T> {
    pub of: T,
    /// When it appears, in seconds.
    pub from_s: f64,
    /// When it disappears, if it does, in seconds.
    pub until_s: Option<f64>,
}

impl<T: Clone> Timed<T> {
    /// Whether it is there at a time in seconds.
    pub fn is_on(&self, t_s: f64) -> bool {
        within(t_s, self.from_s, self.until_s)
    }

    /// Those of several that are there at a time in seconds.
    pub fn those_at(all: &[Self], t_s: f64) -> Vec<T> {
        let there = all.iter().filter(|timed| timed.is_on(t_s));
        there.map(|timed| timed.of.clone()).collect()
    }
}
