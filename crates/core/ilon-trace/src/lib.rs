//! The **record** of a run: the signals of every control step, slip, figures and files.
//!
//! The simulation loop pushes [`Record`]s into a [`Trace`]. A report needs nothing else: it can be
//! made from a trace file without physics. The crate depends on no physics engine and no
//! controller.
//!
//! | module | contents |
//! |---|---|
//! | [`record`] | the record of one control step |
//! | [`trace`] | the whole run: header and records |
//! | [`metrics`] | the figures of a run, as in `summary.json` |
//! | [`quantities`] | names, descriptions and units of these figures |
//! | [`convergence`] | the change of these figures at half the step |
//! | [`ledger`] | the error budget: commanded minus real motion, by causes |
//! | [`slip`] | sliding of the contacts |
//! | [`difference`] | the comparison of a trace with an earlier one |
//! | [`odometry`] | the drift of dead reckoning |
//! | [`file`](mod@file) | the trace as a Parquet file |
//! | [`parts`] | the trace while it grows |
//! | [`recording`] | a run of any length, with only its last rows in memory |
//! | [`rows`] | rows that need not be in memory |
//! | [`sink`] | receivers of rows during a run |

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
mod numbers;
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
pub use difference::{Difference, differences};
pub use effects::{Effect, Effects};
pub use error::TraceError;
pub use fault::{Fault, FaultKind};
pub use hash::{hash_of_rows, trace_hash};
pub use header::{
    Announced, BodyHeader, Ground, GroundBox, GroundMap, GroundPatch, GroundRamp, GroundRelief,
    Guidance, Header, JointHeader, MotorLine, WheelHeader,
};
pub use joined::Joined;
pub use ledger::Ledger;
pub use metrics::{JointTravel, Settings, Summary};
pub use numbers::{number, significant, to_microseconds};
pub use quantities::Quantity;
pub use record::{
    BodySample, Desired, ImuSample, ImuVariances, JointSample, MAX_BODIES, MAX_JOINTS, MAX_TASKS,
    Reckoned, Record, Storage, Support, TaskShare, Truth, WheelSample,
};
pub use recording::{Recorded, Recording};
pub use rows::Rows;
pub use sink::Sink;
pub use trace::Trace;
