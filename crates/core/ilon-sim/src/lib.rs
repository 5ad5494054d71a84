//! The crate that **runs** scenarios: it places a robot in its world under its controller, records
//! the run and judges it.
//!
//! A [`Scenario`] names a robot, its motion and its world; [`run`] simulates it and returns the
//! trace and its summary:
//!
//! ```no_run
//! let scenario = ilon_sim::Scenario::load("assets/scenarios/volksbot_position_first.toml")?;
//! let run = ilon_sim::run(&scenario)?;
//! println!("{:?} m off at the end", run.summary.position_error_final_m);
//! # Ok::<(), ilon_sim::Error>(())
//! ```
//!
//! | module | contents |
//! |---|---|
//! | [`simulate`] | a run from its start to its figures; re-exports of `ilon-scenario` and `ilon-plant` |
//! | [`causes`] | ablation: the run repeated without one of its causes |
//! | [`judge`] | the comparison of a run with its `[expect]` |
//! | [`inspect`] | a robot as it was understood |
//! | [`standard_motions`] | five motions that characterise a robot |
//!
//! The crate has no command line, no plots and no progress bar.

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod causes;
mod design;
pub mod inspect;
pub mod judge;
pub mod simulate;
pub mod standard_motions;

pub use ilon_control as control;
pub use ilon_files as files;
pub use ilon_formats as formats;
pub use ilon_robot as robot;
pub use ilon_trace as trace;
pub use ilon_world as world;

pub use causes::Causes;
pub use ilon_scenario::robot::remedy;
pub use ilon_scenario::{Error, RobotFault, Scenario, ScenarioFault, foreign, reason, scenario};
pub use simulate::{
    Commanded, Controller, Driver, JointCommand, Measurements, Moment, Outcome, Plant, Resolved,
    Run, Simulation, Snapshot, WheelCommand, gathered, load_robot, resolve, resolve_for, run,
};
