//! Only dependencies with features.
//!
//! Cargo builds a dependency anew for each set of features that a selection of packages requires,
//! and with it everything that depends on it. With this crate in the selection the physics engine
//! is built once for the tests with and without optional features, the command, the Python package,
//! and the tests of one crate (`cargo test -p ilon-world -p ilon-features`).
