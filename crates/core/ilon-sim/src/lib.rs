//! What **runs**: a scenario becomes a robot in its world under its controller, and the run is recorded and judged.
//!
//! A [`Scenario`] names a robot, the motion asked of it and the world it stands in; [`run`] simulates it and gives back
//! the trace and its summary:
//!
//! ```no_run
//! let scenario = ilon_sim::Scenario::load("assets/scenarios/volksbot_position_first.toml")?;
//! let run = ilon_sim::run(&scenario)?;
//! println!("{:?} m off at the end", run.summary.position_error_final_m);
//! # Ok::<(), ilon_sim::Error>(())
//! ```
//!
//! | module | answers |
//! |---|---|
//! | [`simulate`] | a run from its beginning to its figures; and what it takes of `ilon-scenario` and `ilon-plant` |
//! | [`causes`] | what makes a difference to a run: the run again without it |
//! | [`judge`] | whether a run met its `[expect]` |
//! | [`inspect`] | a robot as it is understood |
//! | [`standard_motions`] | five motions that show what a robot does |
//!
//! There is no command line, no plot and no progress bar here.

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
    Run, Simulation, Snapshot, WheelCommand, load_robot, resolve, resolve_for, run,
};
