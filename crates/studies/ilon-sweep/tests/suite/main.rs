//! The tests of `ilon-sweep` from outside, one module per subject, in one program.

mod findings;
mod materials;
mod parts;
mod results;
mod study;
mod support;
