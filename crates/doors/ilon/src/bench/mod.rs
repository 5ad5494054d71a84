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
//! - **Treads**: the time of a step on compliant rollers over that on rigid ones, timed like speed
//!   and in turn.
//! - **Sliding**: drives in which wheels slide, with contacts solved by ilon and by rapier: path,
//!   heat and energy balance, against ilon's own contacts at a quarter of the step.
//! - **Many robots**: simulated time of all robots over wall clock. All live in one process and are
//!   stepped from outside, each by a control period of 50 ms at a time: sensors, wheel loops,
//!   motors and world, without recording.

mod configuration;
mod fleet;
mod machine;
mod measure;
mod options;
mod scenario;
mod transients;
mod tread;

pub use ilon_report::bench::{
    Bench, BenchDrive, Configuration, DRIVES, FLEET_RATE_HZ, Heading, Machine, RobotBench, Slide,
    Throughput, Transient, TreadCost,
};
pub use measure::measure;
pub use options::{ContactMode, Options, ROBOTS};
