//! What is known of a quantity.

use crate::metrics::Summary;

/// The unit that a quantity is shown in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// As it stands behind the number; empty of a pure number.
    pub symbol: &'static str,
    /// How many of it make one SI unit.
    pub per_si: f64,
}

/// One figure of a [`Summary`].
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Quantity {
    /// Its name in `summary.json` and in `[expect]`; a dot steps into a group, as in `twist_ratio_ideal.vy`.
    pub key: &'static str,
    /// What it is, in words, to be read under its group's heading.
    pub label: &'static str,
    /// The unit that it is shown in.
    pub unit: Unit,
    /// Digits behind the point when it is shown.
    pub decimals: usize,
    /// Whether it belongs in a table that has room for the main figures only.
    pub is_main: bool,
    pub(super) get: fn(&Summary) -> Option<f64>,
}

impl Quantity {
    /// Its value in SI units, as in `summary.json`; `None` where it does not apply to the run.
    pub fn value(&self, summary: &Summary) -> Option<f64> {
        (self.get)(summary)
    }

    /// Its value in the unit that it is shown in; `None` where it does not apply to the run.
    pub fn shown(&self, summary: &Summary) -> Option<f64> {
        self.value(summary).map(|value| value * self.unit.per_si)
    }
}

/// Quantities under one heading.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Group {
    /// The heading.
    pub heading: &'static str,
    /// Whether they say something of open-loop runs only: a robot that tracks a path goes to and fro, and its mean
    /// twist is nothing to measure by.
    pub open_loop_only: bool,
    /// The quantities, in the order in which they are shown.
    pub quantities: &'static [Quantity],
}
