//! Pages that show more than a trace: how accurate and fast the simulation is, a robot alone, robots side by side, designs,
//! identifications.
//!
//! They are built of the sections and figures of [`ilon_report`].

pub mod bench;
pub mod design;
pub mod gallery;
pub mod identify;
pub mod robot;
pub mod sweep;
