//! The tests of `ilon-live` from outside, one module for each subject, in one program.

mod ardupilot;
mod foxglove;
mod joints;
mod server;
