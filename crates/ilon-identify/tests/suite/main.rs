//! The tests of `ilon-identify` from outside, one module for each subject, in one program.

mod bad_logs;
mod doubts;
mod fit;
mod floors;
mod phases;
mod rollers;
mod studies;
mod support;
mod synthetic;
