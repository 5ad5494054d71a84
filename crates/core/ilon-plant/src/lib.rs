//! The **plant**: a robot in its world with motors, wheel loops, sensors and faults; its drivers
//! and its recorder.
//!
//! | module | contents |
//! |---|---|
//! | [`plant`] | robot, world, motors, sensors and faults, and the outcome of a step |
//! | [`clock`] | simulated time and CPU time |
//! | [`wheels`] | the loops and motors that convert commands to torques |
//! | [`sensing`] | encoders, IMU, pose sensor and dead reckoning |
//! | [`ground`] | the scenario's floor: surfaces, patches and heights |
//! | [`faults`] | injected faults: pushes, payloads, lost motors and sensors |
//! | [`pilot`] | the source of wheel rates: guidance, log, twist, or a caller's controller |
//! | [`record`] | rows and header of a run, and the loop of one run |
//! | [`mod@resolve`] | a scenario with nothing left open, for a robot and a driver |
//! | [`limits`] | the accelerations that grip and motors allow |
//!
//! A [`Plant`] decides nothing and records nothing.

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod bodies;
pub mod clock;
pub mod faults;
pub mod ground;
pub mod limits;
mod noise;
pub mod pilot;
pub mod plant;
pub mod record;
pub mod resolve;
pub mod sensing;
mod storage;
mod timed;
pub mod wheels;

pub use ilon_scenario::course::command::{Commanded, Decided, JointCommand, WheelCommand};
pub use ilon_scenario::{Error, Resolved, Scenario};
pub use plant::{Outcome, Plant, Snapshot};
pub use resolve::{Driver, resolve, resolve_for};
