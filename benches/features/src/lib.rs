//! Nothing but dependencies with features.
//!
//! Cargo builds a dependency anew for each set of features that a selection of packages asks of it, and with it all that stands on it. Whoever selects
//! this crate too builds the physics engine once: the tests with and without what is optional, the command, and the Python package.
