//! The properties of a quantity.

use crate::metrics::Summary;

/// The unit for display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// The symbol after the number; empty for a pure number.
    pub symbol: &'static str,
    /// How many of this unit make one SI unit.
    pub per_si: f64,
}

/// The reference of an accuracy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Measure {
    /// The figure itself.
    Itself,
    /// For a length: the path of the farthest wheel, travelled or turned, and at least that wheel's
    /// distance from the body's origin, in metres.
    Way,
    /// For an angle: that path over the wheel's distance from the body's origin, in radians.
    Turn,
}

/// The accuracy of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Accuracy {
    /// Its reference.
    pub of: Measure,
    /// The share of the reference.
    pub share: f64,
}

/// The possible values of a figure, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Limits {
    /// Smallest.
    pub least: f64,
    /// Largest.
    pub most: f64,
    /// Whether every run has the figure, and keeps the limits even if its step is too long: then
    /// losses can come out below zero, and an error may never settle.
    pub is_certain: bool,
}

impl Limits {
    /// Distances, sizes, times, and sums that only grow.
    pub(super) const SIZE: Self = Self::up_to(f64::INFINITY, true);
    /// Shares.
    pub(super) const SHARE: Self = Self::up_to(1.0, true);
    /// Losses.
    pub(super) const LOSS: Self = Self::up_to(f64::INFINITY, false);
    /// Sizes that not every run has: those of a path, a pose sensor, dead reckoning over some distance,
    /// or a mean motion.
    pub(super) const SIZE_IF_ANY: Self = Self::up_to(f64::INFINITY, false);
    /// Shares that not every run has: those of redundant wheels, tasks, and a chassis that stands on
    /// the ground.
    pub(super) const SHARE_IF_ANY: Self = Self::up_to(1.0, false);

    const fn up_to(most: f64, is_certain: bool) -> Self {
        Self {
            least: 0.0,
            most,
            is_certain,
        }
    }
}

/// One figure of a [`Summary`].
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Quantity {
    /// Its name in `summary.json` and in `[expect]`; a dot leads into a group, as in
    /// `twist_ratio_ideal.vy`.
    pub key: &'static str,
    /// Its description, to be read under its group's heading.
    pub label: &'static str,
    /// The unit for display.
    pub unit: Unit,
    /// Decimals for display.
    pub decimals: usize,
    /// Whether it belongs in a table of the main figures only.
    pub is_main: bool,
    /// The stated accuracy, if there is one.
    pub(super) accuracy: Option<Accuracy>,
    /// Whether it is compared between a run and its twins.
    pub(super) is_compared: bool,
    /// The possible range; `None` if it can have either sign.
    pub(super) limits: Option<Limits>,
    pub(super) get: fn(&Summary) -> Option<f64>,
}

impl Quantity {
    /// The same with a stated accuracy; it is then compared too.
    pub(super) const fn known_to(mut self, accuracy: Accuracy) -> Self {
        self.accuracy = Some(accuracy);
        self.compared()
    }

    /// The same, compared between a run and its twins.
    pub(super) const fn compared(mut self) -> Self {
        self.is_compared = true;
        self
    }

    /// The same within limits.
    pub(super) const fn within(mut self, limits: Limits) -> Self {
        self.limits = Some(limits);
        self
    }

    /// Its value in SI units, as in `summary.json`; `None` if it does not apply to the run.
    pub fn value(&self, summary: &Summary) -> Option<f64> {
        (self.get)(summary)
    }

    /// Its value in the unit for display; `None` if it does not apply to the run.
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
    /// Whether the quantities are meaningful only for open-loop runs: a robot that tracks a path
    /// has no useful mean twist.
    pub open_loop_only: bool,
    /// The quantities in display order.
    pub quantities: &'static [Quantity],
}
