//! What the twins of a run came to, and by how much its figures move between them: as it is stored.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// What a twin has otherwise than the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Change {
    /// Half the physics step; wheel loops keep their period.
    HalfStep,
    /// Half the parts into which steps are split while a roller is about to slide.
    HalfSplit,
}

/// What a run came to with one thing changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Twin {
    /// What was changed.
    pub change: Change,
    /// Its figures by their keys, in SI units: those of which an accuracy is stated, as far as they apply.
    #[serde(default)]
    pub figures: BTreeMap<String, f64>,
    /// Why it has no figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

/// A figure of a run at its own step and at half of it, in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Moved {
    /// In the run at its own step; `None` where it does not apply.
    pub value: Option<f64>,
    /// At half the physics step.
    pub half_step: Option<f64>,
    /// With half the parts into which steps are split; `None` too where no step is split.
    pub half_split: Option<f64>,
    /// By how much it moved at most.
    pub moved: f64,
    /// The same as a share of what the figure is measured against: of a place the way, of all but places and headings the figure itself. 0
    /// where it moved by no more than rounding.
    pub share: f64,
    /// Whether that is more than the accuracy that `docs/measured.md` states.
    pub exceeds: bool,
}

/// How far the figures of a run move at half its step, by their keys; empty where it was not repeated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Convergence(pub(crate) BTreeMap<String, Moved>);

impl Convergence {
    /// Whether the run was not repeated, or could not be.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A figure by its key; `None` where it does not apply.
    pub fn get(&self, key: &str) -> Option<&Moved> {
        self.0.get(key)
    }
}
