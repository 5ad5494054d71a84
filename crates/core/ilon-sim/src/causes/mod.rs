//! What makes a difference to a run: the run repeated with one thing changed, its twin.
//!
//! | file | answers |
//! |---|---|
//! | `null` | which causes a scenario has, and what it is without each |
//! | `remedies` | what is worth a try |
//! | `twin` | one twin, to its end |
//! | `twins` | all of them beside the run |
//! | `path` | how far a run and its twin were apart |
//! | `suspects` | what the usual suspects do to a robot in standard motions |

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

/// Which causes are left out, one after the other, to see what each does to a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Causes {
    /// None: the run alone.
    #[default]
    None,
    /// What the scenario names: faults, what lies on the floor, slope, free bodies, sensors' errors, joints that setpoints move, motors that differ, and what the controller believes; at
    /// most eight. Remedies are tried where the run is short.
    Named,
    /// All that can make a difference: also sliding, the rollers' geometry and make, bearings, motors, wheel loops, other joints and the control period.
    All,
}
