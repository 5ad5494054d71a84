//! The tests of `ilon-identify` from outside, one module for each subject, in one program.

mod anomalies;
mod bad_logs;
mod fit;
mod floors;
mod phases;
mod rollers;
mod studies;
mod support;
mod synthetic;
