//! The accuracy and speed of the simulation on this machine, from five open-loop drives at several
//! steps and headings.
//!
//! The measured loop is that of `ilon run`: sensors, wheel loops, motors, world and recording.
//!
//! - **Error** of a drive: the largest deviation of its mean twist from the contact kinematics, in
//!   per cent, over the commanded components and over the headings. A drive has 1 s of rest, a ramp
//!   of 0.5 s and 4 s at the held twist, of which the last 3 s count.
//! - **Speed**: simulated time over the CPU time of the simulating thread, at the held twist, after
//!   1 s of warm-up. The best of several stretches of at least one simulated second each counts,
//!   with one row of the trace per second.

mod configuration;
mod figures;
mod machine;
mod measure;
mod options;
mod scenario;

pub(crate) use figures::CONFIGURATION_COLUMNS;
pub use figures::{Bench, BenchDrive, Configuration, DRIVES, Heading, Machine, RobotBench};
pub use measure::measure;
pub use options::{ContactMode, Options, ROBOTS};
