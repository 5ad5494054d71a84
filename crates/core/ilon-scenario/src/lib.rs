//! What is to be **run**: the scenario's file, the files that it names, and the same scenario with nothing left open.
//!
//! | module | answers |
//! |---|---|
//! | [`scenario`] | what a person writes down about a run: one struct a section, its keys, its checks |
//! | [`robot`] | the robot of a scenario: its file read, remedies for a refused one, and what the controller takes it for |
//! | [`course`] | what is asked at each time of the run: references, logs, targets of joints |
//! | [`foreign`] | tables of numbers in files that somebody else named, and what messages may show of such files |
//! | [`height_map`] | the ground's heights from an image or a table |
//! | [`choices`] | what the program chooses where a scenario leaves it open, and [`Resolved`], which has all of it |
//!
//! Nothing is simulated here. What makes a [`Resolved`] of a [`Scenario`] also looks at how its robot will move: `resolve` of `ilon-plant`.

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
