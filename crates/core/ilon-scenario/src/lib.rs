//! The **scenario**: its file, the files that it names, and the same scenario with nothing left
//! open.
//!
//! | module | contents |
//! |---|---|
//! | [`scenario`] | the scenario file: one struct per section, its keys, its checks |
//! | [`robot`] | the robot of a scenario: its file read, remedies for a refused one, the controller's belief |
//! | [`course`] | the demand at each time of the run: references, logs, joint targets |
//! | [`foreign`] | tables of numbers in files of unknown origin, and what messages may show of them |
//! | [`height_map`] | ground heights from an image or a mesh |
//! | [`choices`] | choices of the program, and [`Resolved`] with all of them |
//!
//! Nothing is simulated here. The conversion of a [`Scenario`] to a [`Resolved`] also predicts the
//! robot's motion, so it is in `ilon-plant`: `resolve`.

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod choices;
pub mod course;
mod error;
pub mod foreign;
pub mod height_map;
pub mod robot;
pub mod scenario;

pub use choices::{Choices, Resolved};
pub use error::{Error, RobotFault, ScenarioFault, reason};
pub use scenario::Scenario;
