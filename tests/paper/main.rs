//! Indiveri 2009 across crates: the shipped robots read from their files, and the dynamic model (11) held against a
//! simulated robot. What needs the control crate alone is tested in `crates/ilon-control/tests/paper`.

mod computed_torque;
mod dynamics;
mod low_level;
mod reference_point;
mod robots;
mod section_iv;
