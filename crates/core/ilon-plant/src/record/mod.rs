//! What of a run becomes rows and a header, and the loop of one run: plant, pilot, recorder.

pub(crate) mod budget;
pub mod header;
pub(crate) mod period;
pub mod recorder;
pub mod run_loop;
