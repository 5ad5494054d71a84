//! The tests of `ilon-oracle` from outside, one module per subject, in one program.

mod free_flight;
mod input;
mod joints;
mod oracle;
mod rolling;
mod sliding;
mod support;
