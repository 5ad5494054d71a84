//! Fits a robot's real parameters to logs of its drives.
//!
//! A log contains the wheels' angles and the robot's pose from an external tracker. Two steps
//! follow: the kinematics (radii, levers, the roller angle, or gains by direction) by least squares
//! on displacements; and keys of the scenario (compliance of the rollers, properties of the floor)
//! by simulating the runs.
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
//! | module | content |
//! |---|---|
//! | `study` | the user's study file |
//! | [`log`] | reading logs, and their anomalies |
//! | `controller` | settings for a controller |
//! | [`delay`] | delay of the tracker's poses behind the wheels |
//! | [`motion`] | displacements in the body frame, over short windows |
//! | [`model`] | free parameters of the kinematics |
//! | [`kinematic_fit`] | values, noise, and which parameters a log determines |
//! | [`scatter`] | uncertainty of the values |
//! | `steered` | steered tyres as wheels that are not steered |
//! | `simulate` | keys of the scenario, by simulating |
//! | [`plan`] | a course that determines the free parameters |
//! | [`tape`] | the same from runs whose ends were measured by tape |
//! | [`outcome`] | the results as written |
//!
//! The crate has no command line and no plots.

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
mod steered;
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
