//! A simulated robot as a functional mock-up unit (FMU): FMI 3.0, co-simulation.
//!
//! The archive holds the scenario as it is run, the robot's files, and the shared library of `ilon-c`, whose `fmi3` functions call an
//! [`Instance`]. Description and instance go by one table of [`Variable`]s, made from the scenario, so that they cannot disagree.
//!
//! | module | answers |
//! |---|---|
//! | [`variables`] | what can be set and read, with units, and under which references |
//! | [`keys`] | which keys of the scenario are parameters |
//! | [`instance`] | what an instance does between two calls |
//! | [`description`] | `modelDescription.xml` |
//! | [`package`](mod@package) | the archive |
//!
//! Why not the crate `fmi-export`: it makes the table of variables from a struct when a library is compiled, and here a scenario makes it when
//! an FMU is exported.

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod description;
pub mod instance;
pub mod keys;
mod outputs;
pub mod package;
mod value;
mod variable;
pub mod variables;

pub use instance::{Instance, Phase};
pub use package::package;
pub use value::Value;
pub use variable::{Causality, Variable};

/// Stands in the shared library, so that an exporter knows one of its own version.
pub const MARK: &str = concat!("ilon functional mock-up unit ", env!("CARGO_PKG_VERSION"));

/// The identifier by which an FMU names its shared library.
pub const MODEL: &str = "ilon";

/// The scenario's name within the resources.
pub const SCENARIO: &str = "scenario.toml";
