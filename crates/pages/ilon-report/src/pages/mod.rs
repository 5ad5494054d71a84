//! Pages that show more than a trace: how accurate and fast the simulation is, a robot alone, robots side by side, designs,
//! identifications.
//!
//! They are built of the sections and figures of a report, from data of the crates that find it: only with the feature `studies`, but for that of
//! measurements.

pub mod bench;
#[cfg(feature = "studies")]
pub mod design;
#[cfg(feature = "studies")]
pub mod gallery;
#[cfg(feature = "studies")]
pub mod identify;
#[cfg(feature = "studies")]
pub mod limits;
#[cfg(feature = "studies")]
pub mod robot;
#[cfg(feature = "studies")]
pub mod sweep;
