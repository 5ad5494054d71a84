//! The tests of `ilon-messages` from outside, one module for each subject, in one program.

mod bag;
mod common;
mod fixtures;
mod row;
mod strangers;
mod witness;
