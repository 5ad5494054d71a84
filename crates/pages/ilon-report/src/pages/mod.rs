//! Pages that show more than a trace: single robots, robots side by side, identifications.
//!
//! They consist of the sections and figures of a report, with data of other crates.

mod design;
pub mod gallery;
pub mod identify;
pub mod limits;
pub mod robot;
pub mod sweep;
