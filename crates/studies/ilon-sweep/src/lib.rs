//! Many runs of a scenario with varied keys: study files, parallel execution, and findings.
//!
//! ```no_run
//! use ilon_sweep::{Options, Store, Study, sweep};
//!
//! let study = Study::load("assets/studies/friction_path_loss.toml")?;
//! let findings = sweep(&study, &Store::in_memory(), &Options::default(), &|_| ())?;
//! println!("{:?}", findings.found);
//! # Ok::<(), ilon_sim::Error>(())
//! ```
//!
//! A run is a function of its number and the study, so the same study gives the same rows on a
//! laptop and on a cluster, however its parts are distributed ([`Study::run_parts`], [`Shard`]).
//!
//! | module | content |
//! |---|---|
//! | `file` | the study file |
//! | `axis`, `sample` | the values of a run |
//! | `evaluate`, `row` | one run and its row |
//! | `engine`, `parts` | a whole study on a machine's cores, or parts of it for others |
//! | [`store`](Store) | persistent rows |
//! | `find`, `minimise` | searches |
//! | [`findings`](mod@findings) | findings from the rows |
//!
//! The crate has no command line, no plots and no progress bar.

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod axis;
mod axis_syntax;
mod base;
mod check;
mod engine;
mod evaluate;
mod file;
pub mod findings;
mod hash;
mod keep_traces;
mod minimise;
mod options;
mod robots;
mod row;
mod run_parts;
mod sample;
mod shard;
mod store;
mod study;
mod table;
mod threshold;
mod value_names;

pub use axis::{Axis, Values, number_of, text_of};
pub use engine::{findings, keep_traces, sweep, write_results};
pub use file::{Find, Keep, Method, Minimise, OneBound, OneOrMany, Scale, ShareBound, StudyFile};
pub use findings::Findings;
pub use minimise::Minimum;
pub use options::{Options, Progress, Stop};
pub use row::{Row, Status, Task, figure_index, figure_names};
pub use shard::Shard;
pub use store::Store;
pub use study::{Column, Question, Study};
pub use table::{Cells, columns, write_runs};
pub use threshold::{Crossing, SearchOutcome};
