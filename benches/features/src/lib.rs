//! Nothing but dependencies with features.
//!
//! Cargo builds a dependency anew for each set of features that a selection of packages asks of it, and with it all that stands on it. Whoever selects
//! this crate too builds the physics engine once: the tests with and without what is optional, the command, the Python package, and the tests of one
//! crate (`cargo test -p ilon-world -p ilon-features`).
