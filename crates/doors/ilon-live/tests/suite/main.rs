//! The tests of `ilon-live` from outside, one module per subject, in one program.

mod ardupilot;
mod foxglove;
mod joints;
mod server;
