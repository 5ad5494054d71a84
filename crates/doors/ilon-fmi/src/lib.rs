//! A simulated robot as a functional mock-up unit (FMU): FMI 3.0, co-simulation.
//!
//! The archive holds the resolved scenario, the robot's files, and the shared library of `ilon-c`,
//! whose `fmi3` functions call an [`Instance`]. Description and instance use one table of
//! [`Variable`]s, made from the scenario, so that they always agree.
//!
//! | module | answers |
//! |---|---|
//! | [`variables`] | what can be set and read, with units and value references |
//! | [`keys`] | which keys of the scenario are parameters |
//! | [`instance`] | the simulation behind an instance |
//! | [`description`] | `modelDescription.xml` |
//! | [`package`](mod@package) | the archive |
//!
//! The crate `fmi-export` is not used: it makes the table of variables from a struct when a library
//! is compiled, and here a scenario makes it when an FMU is exported.

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

/// A mark in the shared library, by which an exporter recognises its own version.
pub const MARK: &str = concat!("ilon functional mock-up unit ", env!("CARGO_PKG_VERSION"));

/// The identifier by which an FMU names its shared library.
pub const MODEL: &str = "ilon";

/// The scenario's file name in the resources.
pub const SCENARIO: &str = "scenario.toml";
