//! Ablation: the run is repeated with one thing changed (its *twin*) to measure what that thing
//! does.
//!
//! | file | contents |
//! |---|---|
//! | `null` | the causes of a scenario, and the scenario without each |
//! | `remedies` | changes worth trying |
//! | `twin` | one twin, run to its end |
//! | `twins` | all twins of a run, in parallel with it |
//! | `path` | the distance between a run and its twin |
//! | `suspects` | the effect of common defects in standard motions |

mod null;
mod path;
mod remedies;
mod suspects;
mod twin;
mod twins;

pub(crate) use path::Path;
pub(crate) use remedies::has_remedies;
pub use suspects::{Drift, Lineup, Suspect, suspects};
pub(crate) use twins::{TwinOutcomes, Twins};

/// Which causes are removed, one at a time, to measure the effect of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Causes {
    /// None: the run alone.
    #[default]
    None,
    /// Those that the scenario names: faults, obstacles, slope, free bodies, sensor errors, joints
    /// moved by setpoints, motors that differ, and a false belief of the controller; at most eight.
    /// Remedies are tried if the run is short.
    Named,
    /// All of these, and also sliding, geometry and manufacture of the rollers, bearings, motors,
    /// wheel loops, other joints and the control period.
    All,
}
