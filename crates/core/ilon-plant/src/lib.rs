//! What **steps**: a robot in its world with motors, wheel loops, sensors and faults; what drives it, and what records it.
//!
//! | module | answers |
//! |---|---|
//! | [`plant`] | robot, world, motors, sensors and faults: what acts, and the result |
//! | [`clock`] | the time of a run, and the processor's |
//! | [`wheels`] | the loops and motors that turn commands into torques |
//! | [`sensing`] | what encoders, IMU and pose sensors measure, and dead reckoning |
//! | [`ground`] | the floor that a scenario describes: its surfaces, patches and heights |
//! | [`faults`] | what goes wrong on purpose: pushes, payloads, lost motors and sensors |
//! | [`pilot`] | who decides the wheels' rates: guidance, log, twist, or a controller of the caller's |
//! | [`record`] | what of a run becomes rows and a header, and the loop of one run |
//! | [`mod@resolve`] | a scenario with nothing left open, made for a robot and a driver |
//! | [`limits`] | which accelerations grip and motors allow |
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
pub mod wheels;

pub use ilon_scenario::course::command::{Commanded, Decided, JointCommand, WheelCommand};
pub use ilon_scenario::{Error, Resolved, Scenario};
pub use plant::{Outcome, Plant, Snapshot};
pub use resolve::{Driver, resolve, resolve_for};
