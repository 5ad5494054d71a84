//! The tests of `ilon-identify` from outside, one module per subject, in one program.

mod anomalies;
mod bad_logs;
mod floors;
mod kinematic_fit;
mod phases;
mod rollers;
mod steered;
mod studies;
mod support;
mod synthetic;
mod tape;
