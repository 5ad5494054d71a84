//! The tests of `ilon-sweep` from outside, one module for each subject, in one program.

mod findings;
mod materials;
mod parts;
mod results;
mod study;
mod support;
