//! Fits what a robot really is to logs of its drives.
//!
//! A log says what the wheels did and where something outside saw the robot. From that follow, in two steps, the kinematics (radii,
//! levers, the roller angle, or gains by direction: least squares on displacements) and, by simulating the runs, keys of the scenario:
//! how the rollers give, what the floor does.
//!
//! ```no_run
//! use ilon_identify::{Study, identify};
//!
//! let study = Study::load("assets/identify/optiodom_omni3.toml")?;
//! let identified = identify(&study, &|_| ())?;
//! for (name, parameter) in &identified.parameters {
//!     println!("{name} = {} {}", parameter.value, parameter.unit);
//! }
//! # Ok::<(), ilon_sim::Error>(())
//! ```
//!
//! | module | answers |
//! |---|---|
//! | `study` | what a person writes down |
//! | [`log`] | what a log says, and what is wrong with it |
//! | `controller` | what a controller is to be set to |
//! | [`delay`] | by how much the tracker's poses come after the wheels |
//! | [`motion`] | displacements in the body frame, over short stretches |
//! | [`model`] | what of the kinematics can be free |
//! | [`kinematic_fit`] | values, noise, and what a log determines |
//! | [`scatter`] | how sure the values are |
//! | `simulate` | keys of the scenario, by simulating |
//! | [`plan`] | which course determines what is free |
//! | [`tape`] | the same from runs of which a tape measured the ends |
//! | [`outcome`] | what was found, as it is written |
//!
//! There is no command line and no plot here.

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod checked_logs;
mod controller;
pub mod delay;
mod directions;
mod identify;
pub mod kinematic_fit;
mod least_squares;
pub mod log;
pub mod model;
mod model_choice;
pub mod motion;
pub mod outcome;
pub mod plan;
mod read_logs;
mod result_files;
mod ripple;
pub mod scatter;
mod simulate;
mod study;
mod study_file;
pub mod tape;

pub use identify::{Progress, identify};
pub use least_squares::{Minimum, Search, least_squares};
pub use log::Log;
pub use outcome::Identified;
pub use result_files::{FILES, files};
pub use study::{
    BesideFile, CurrentsFile, HeadingFile, Logged, ModelFile, Phases, RippleFile, RunFile,
    Simulate, Study, StudyFile,
};
