//! What a run **recorded**: the signals of every control step, the slip in them, metrics, and files.
//!
//! A [`Trace`] is what the simulation loop pushes [`Record`]s into, and all that a report needs: reports are made
//! again from a trace file without physics. Nothing here knows of a physics engine or of a controller.
//!
//! | module | answers |
//! |---|---|
//! | [`record`] | what is recorded at one control step |
//! | [`trace`] | the whole run: header and records |
//! | [`metrics`] | the figures of a run, as in `summary.json` |
//! | [`quantities`] | the names, words and units of those figures |
//! | [`convergence`] | how far those figures move at half the step |
//! | [`ledger`] | where the difference between asked and real motion goes |
//! | [`slip`] | how the contacts slid |
//! | [`difference`] | where a trace leaves an earlier one |
//! | [`odometry`] | how far dead reckoning drifts |
//! | [`file`](mod@file) | the trace as a Parquet file |
//! | [`parts`] | the trace while it grows |
//! | [`recording`] | a run of any length, of which only the last rows lie in memory |
//! | [`rows`] | rows that need not lie in memory |
//! | [`sink`] | where rows go while a run is under way |

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod accumulate;
mod balance;
mod budget;
mod columns;
pub mod convergence;
mod design;
pub mod difference;
mod effect;
pub mod effects;
mod error;
mod fault;
pub mod file;
mod finite;
mod fold;
mod hash;
mod header;
mod joined;
mod joint_travel;
pub mod ledger;
pub mod metrics;
pub mod odometry;
pub mod parts;
pub mod quantities;
pub mod record;
pub mod recording;
pub mod rows;
#[cfg(test)]
mod sample;
mod signal;
pub mod sink;
pub mod slip;

pub mod trace;
mod twin;

pub use accumulate::Figures;
pub use columns::{ColumnType, Signal};
pub use convergence::{Apart, Cause, Change, Convergence, Twin};
pub use design::Design;
pub use difference::{Difference, differences, number, to_microseconds};
pub use effects::{Effect, Effects};
pub use error::TraceError;
pub use fault::{Fault, FaultKind};
pub use hash::{hash_of_rows, trace_hash};
pub use header::{
    Announced, BodyHeader, BodyShape, Ground, GroundBox, GroundMap, GroundPatch, GroundRamp,
    GroundRelief, Guidance, Header, JointHeader, MotorLine, WheelHeader,
};
pub use joined::Joined;
pub use ledger::Ledger;
pub use metrics::{JointTravel, Settings, Summary};
pub use quantities::Quantity;
pub use record::{
    BodySample, Desired, ImuSample, ImuVariances, JointSample, MAX_BODIES, MAX_JOINTS, MAX_TASKS,
    Reckoned, Record, Storage, Support, TaskShare, Truth, WheelSample,
};
pub use recording::{Recorded, Recording};
pub use rows::Rows;
pub use sink::Sink;
pub use trace::Trace;
