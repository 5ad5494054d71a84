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
//! | [`ledger`] | where the difference between asked and real motion goes |
//! | [`slip`] | how the contacts slid |
//! | [`odometry`] | how far dead reckoning strays |
//! | [`file`](mod@file) | the trace as a Parquet file |
//! | [`parts`] | the trace while it grows |

mod columns;
mod error;
pub mod file;
mod hash;
pub mod ledger;
pub mod metrics;
pub mod odometry;
pub mod parts;
pub mod record;
#[cfg(test)]
mod sample;
mod signal;
pub mod slip;
pub mod trace;

pub use error::TraceError;
pub use hash::trace_hash;
pub use ledger::Ledger;
pub use metrics::{Settings, Summary};
pub use record::{Desired, MAX_TASKS, Record, TaskShare, Truth, WheelSample};
pub use trace::{Header, Trace, WheelHeader};
