//! What a run **recorded**: the signals of every control step, the slip in them, metrics, and files.
//!
//! A [`Trace`] is what the simulation loop pushes [`Record`]s into, and all that a report needs: reports are made
//! again from a trace file without physics. Nothing here knows of a physics engine or of a controller.
//!
//! | module | answers |
//! |---|---|
//! | [`record`] | what is recorded at one control step |
//! | [`trace`] | the whole run: header and records |

pub mod record;
pub mod trace;

pub use record::{Desired, MAX_TASKS, Record, TaskShare, Truth, WheelSample};
pub use trace::{Header, Trace, WheelHeader};
