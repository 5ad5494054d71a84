//! The compiled half of the Python package `ilon`; the other half, in `package/ilon`, is what users
//! import.
//!
//! | module | is |
//! |---|---|
//! | `run`, `trace` | whole runs, and their traces |
//! | `simulation`, `moments` | a robot that is driven step by step |
//! | `study` | many runs of a scenario with varied keys |
//! | `identify` | fits of a robot's parameters to logs |
//! | `track` | the learning task, for many robots at once |
//! | `tools` | inspect, generate, compare, judge, the command |
//! | `scenario`, `values`, `typed` | scenarios and values from Python, and to it |
//! | `errors` | errors as exceptions |

#![warn(clippy::print_stderr, clippy::print_stdout)]

mod errors;
mod identify;
mod moments;
mod run;
mod scenario;
mod simulation;
mod study;
mod tools;
mod trace;
mod track;
mod typed;
mod values;

/// The compiled half of `ilon`.
#[pyo3::pymodule]
mod _ilon {
    #[pymodule_export]
    use crate::identify::identify;
    #[pymodule_export]
    use crate::moments::{Body, Desired, FreeBody, Imu, Observation, Outcome, Truth, Wheels};
    #[pymodule_export]
    use crate::run::{Run, Torques, run};
    #[pymodule_export]
    use crate::simulation::{Simulation, Snapshot};
    #[pymodule_export]
    use crate::study::{Rows, Study, Sweep, merge_sweeps};
    #[cfg(feature = "command")]
    #[pymodule_export]
    use crate::tools::command;
    #[pymodule_export]
    use crate::tools::{compare, generate, inspect, judged, schema, suspects};
    #[pymodule_export]
    use crate::trace::{ArrowTable, Recorded};
    #[pymodule_export]
    use crate::track::Track;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
