//! The stored effect of a cause on a figure of a run.

use serde::{Deserialize, Serialize};

/// Key of an [`Effect`]: the largest distance between a run and its twin at the same time, in
/// metres; without the cause it is 0.
pub const APART_M: &str = "apart_m";
/// Key of an [`Effect`]: the largest difference of their headings at the same time, in radians.
pub const APART_RAD: &str = "apart_rad";

/// A figure with a cause and without it, in SI units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Effect {
    /// The key of the cause in the scenario, such as `faults.0`; `all` for all causes together, and
    /// `interplay` for their joint effect minus the sum of the single ones.
    pub cause: String,
    /// A description of the cause.
    pub words: String,
    /// The figure: a key of the summary, [`APART_M`] or [`APART_RAD`].
    pub key: String,
    /// With the cause; `None` if it does not apply.
    pub with: Option<f64>,
    /// Without the cause; `None` if it does not apply.
    pub without: Option<f64>,
    /// With minus without; of headings, the difference within half a turn.
    pub difference: f64,
    /// Noise floor: the change of the figure without any cause.
    pub floor: f64,
    /// Whether the difference is significant: more than [`FLOORS`](crate::effects::FLOORS) floors.
    pub differs: bool,
}

/// The effects of a run, one cause after the other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Effects(Vec<Effect>);

impl Effects {
    /// Wraps a list of effects.
    pub(crate) fn new(effects: Vec<Effect>) -> Self {
        Self(effects)
    }

    /// Whether no cause was removed from the run.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Iterates in the order of the causes.
    pub fn iter(&self) -> impl Iterator<Item = &Effect> {
        self.0.iter()
    }

    /// The effect of a cause on a figure, by the keys of both.
    pub fn get(&self, cause: &str, key: &str) -> Option<&Effect> {
        let mut of_both = self.0.iter();
        of_both.find(|effect| effect.cause == cause && effect.key == key)
    }
}
