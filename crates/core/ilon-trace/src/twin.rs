//! The results of a run's twins, and the change of its figures between them, as stored.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The difference between a twin and the run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Change {
    /// Half the physics step; wheel loops keep their period.
    HalfStep,
    /// Half the parts into which steps are split while a roller slides or is about to.
    HalfSplit,
    /// Another seed of the sensors' noise.
    OtherSeed,
    /// A start beside the run's by less than anything can mean, counted from 0.
    StartBeside(u32),
    /// One cause removed: replaced by something without effect.
    Without(Cause),
    /// All causes removed that other twins remove one at a time.
    WithoutAll,
    /// With a remedy.
    With(Cause),
}

impl Change {
    /// Whether the twin measures the noise floor instead of an effect.
    pub fn is_noise(&self) -> bool {
        matches!(
            self,
            Self::HalfStep | Self::HalfSplit | Self::OtherSeed | Self::StartBeside(_)
        )
    }
}

/// A possible cause of a difference, or a remedy.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cause {
    /// Its key in the scenario, such as `faults.0` or `world.floor.slope_deg`; for a remedy, the
    /// line to write.
    pub key: String,
    /// A description to follow "without" or "with": `the payload of 2 kg`.
    pub words: String,
}

/// The distance between a run and its twin: the run minus the twin, about the origin of the body
/// frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Apart {
    /// Largest distance at the same time, in metres.
    pub most_m: f64,
    /// Time of that, in seconds.
    pub most_at_s: f64,
    /// Largest magnitude of the heading difference at the same time, in radians.
    pub most_rad: f64,
    /// Time of that, in seconds.
    pub most_rad_at_s: f64,
    /// Final distance of the run ahead of the twin, along the twin's heading, in metres.
    pub ahead_m: f64,
    /// Final distance of the run to the left of the twin, in metres.
    pub left_m: f64,
    /// Final heading of the run minus that of the twin, in radians.
    pub turned_rad: f64,
    /// Largest tilt of the twin: the angle between its z axis and the floor's normal, in radians.
    pub twin_leaned_rad: f64,
}

/// The results of a run with one thing changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Twin {
    /// The change.
    pub change: Change,
    /// Its figures by their keys, in SI units, as far as they apply.
    #[serde(default)]
    pub figures: BTreeMap<String, f64>,
    /// The distance between the run and the twin; `None` if unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub apart: Option<Apart>,
    /// The poses of its body frame, in order of time: time in seconds, x and y in metres, heading
    /// in radians, rounded to 1e-5.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<[f64; 4]>,
    /// The reason if it has no figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

/// A figure of a run at its own step and at half of it, in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Moved {
    /// At the run's own step; `None` if it does not apply.
    pub value: Option<f64>,
    /// At half the physics step.
    pub half_step: Option<f64>,
    /// With half the parts into which steps are split; also `None` if no step is split.
    pub half_split: Option<f64>,
    /// Its largest change.
    pub moved: f64,
    /// The same as a share of the figure's reference: the path length for a position, the figure
    /// itself for all but positions and headings. 0 if the change is rounding.
    pub share: f64,
    /// Whether the change exceeds the accuracy that `docs/measured.md` states.
    pub exceeds: bool,
}

/// The change of a run's figures at half its step, by key; empty if the run was not repeated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Convergence(pub(crate) BTreeMap<String, Moved>);

impl Convergence {
    /// Whether the run was not repeated, or could not be.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A figure by its key; `None` if it does not apply.
    pub fn get(&self, key: &str) -> Option<&Moved> {
        self.0.get(key)
    }
}
