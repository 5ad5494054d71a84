//! What the twins of a run came to, and by how much its figures move between them: as it is stored.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// What a twin has otherwise than the run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Change {
    /// Half the physics step; wheel loops keep their period.
    HalfStep,
    /// Half the parts into which steps are split while a roller is about to slide.
    HalfSplit,
    /// Another seed of the sensors' noise.
    OtherSeed,
    /// One cause left out: replaced by what has no effect.
    Without(Cause),
    /// All causes left out that others leave out one by one.
    WithoutAll,
    /// A remedy that could be tried.
    With(Cause),
}

impl Change {
    /// Whether what the twin comes to otherwise is no effect of anything, but how well the run is known.
    pub fn is_noise(&self) -> bool {
        matches!(self, Self::HalfStep | Self::HalfSplit | Self::OtherSeed)
    }
}

/// Something that can make a difference to a run, or a remedy.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cause {
    /// Where it stands in the scenario, such as `faults.0` or `world.floor.slope_deg`; of a remedy, what would be written there.
    pub key: String,
    /// What it is, to be read behind "without" or "with": `the payload of 2 kg`.
    pub words: String,
}

/// How far a run and its twin were apart: the run minus the twin, about the origin of the body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Apart {
    /// The largest distance between both at the same time, in metres.
    pub most_m: f64,
    /// When that was, in seconds.
    pub most_at_s: f64,
    /// The largest difference of their headings at the same time, its size, in radians.
    pub most_rad: f64,
    /// When that was, in seconds.
    pub most_rad_at_s: f64,
    /// How far the run ended ahead of the twin, by the twin's heading there, in metres.
    pub ahead_m: f64,
    /// How far it ended to the left of the twin, in metres.
    pub left_m: f64,
    /// How far it ended turned to the left, in radians.
    pub turned_rad: f64,
    /// The most that the twin leaned: the angle of its z axis from the floor's normal, in radians.
    pub twin_leaned_rad: f64,
}

/// What a run came to with one thing changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Twin {
    /// What was changed.
    pub change: Change,
    /// Its figures by their keys, in SI units, as far as they apply.
    #[serde(default)]
    pub figures: BTreeMap<String, f64>,
    /// How far the run was from it; `None` where that is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub apart: Option<Apart>,
    /// Where its body frame went, in the order of time: time in seconds, x and y in metres, heading in radians, rounded to 1e-5.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<[f64; 4]>,
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
