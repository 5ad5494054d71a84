//! Pages that show more than a trace: accuracy and speed of the simulation, single robots, robots
//! side by side, identifications.
//!
//! They consist of the sections and figures of a report, with data of other crates: only with the
//! feature `studies`, except for the bench page.

pub mod bench;
#[cfg(feature = "studies")]
mod design;
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
