//! How right and how fast the simulation is on this machine: five open-loop drives, at several steps and headings.
//!
//! What is measured is the whole loop as `ilon run` runs it: sensors, wheel loops, motors, world and recording.
//!
//! - **Error** of a drive: the worst deviation of its mean twist from the contact kinematics, over the components that
//!   were asked for, in per cent; the worst over the headings. 1 s of rest, 0.5 s of ramp, 4 s held, of which the last 3 s
//!   count.
//! - **Speed**: simulated time over the CPU time of the one thread that simulates, while the twist is held, after a second
//!   of warm-up; the best of several stretches of at least a simulated second each, with a row of the trace a second.
//! - **Treads**: the time of a step on rollers that give over that on rigid ones, timed like speed and in turn.
//! - **Sliding**: drives in which wheels slide, under contacts that ilon solves and under such that rapier does: course, heat,
//!   energy balance, against ilon's own at a quarter of the step.
//! - **Many robots**: simulated time of all together over wall clock, all of them alive in one process and stepped from outside, each
//!   by a control period of 50 ms at a time: sensors, wheel loops, motors and world, without a record.

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
