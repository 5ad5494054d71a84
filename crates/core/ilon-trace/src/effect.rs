//! The stored effect of a cause on a figure of a run.

use serde::{Deserialize, Serialize};

/// The largest distance between a run and its twin at the same time, in metres, as a key of [`Effect`]: with the cause the distance, without it 0.
pub const APART_M: &str = "apart_m";
/// The largest difference of their headings at the same time, in radians.
pub const APART_RAD: &str = "apart_rad";

/// A figure with a cause and without it, in SI units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Effect {
    /// Where the cause stands in the scenario, such as `faults.0`; `all` of all causes together, and `interplay` of what these do beyond the sum of each.
    pub cause: String,
    /// What it is, in words.
    pub words: String,
    /// The figure: a key of the summary, [`APART_M`] or [`APART_RAD`].
    pub key: String,
    /// With the cause; `None` where it does not apply.
    pub with: Option<f64>,
    /// Without the cause; `None` where it does not apply.
    pub without: Option<f64>,
    /// With minus without; of headings within half a turn.
    pub difference: f64,
    /// What the figure moves by without any cause.
    pub floor: f64,
    /// Whether the difference can be told from none: more than [`FLOORS`](crate::effects::FLOORS) floors.
    pub differs: bool,
}

/// The effects of a run: those of one cause after the other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Effects(Vec<Effect>);

impl Effects {
    /// Of these.
    pub(crate) fn new(effects: Vec<Effect>) -> Self {
        Self(effects)
    }

    /// Whether nothing was left out of the run.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// One after the other, in the order of the causes.
    pub fn iter(&self) -> impl Iterator<Item = &Effect> {
        self.0.iter()
    }

    /// The effect of a cause on a figure, by the keys of both.
    pub fn get(&self, cause: &str, key: &str) -> Option<&Effect> {
        let mut of_both = self.0.iter();
        of_both.find(|effect| effect.cause == cause && effect.key == key)
    }
}
