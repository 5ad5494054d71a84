//! Rows and header of a run, and the loop of one run: plant, pilot, recorder.

pub(crate) mod budget;
pub mod header;
pub(crate) mod period;
pub mod recorder;
pub mod run_loop;
