//! The tests of `ilon-messages` from outside, one module per subject, in one program.

mod bag;
mod common;
mod fixtures;
mod row;
mod strangers;
mod witness;
