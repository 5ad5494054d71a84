//! The `ilon` command: its arguments, its output and its exit codes.

mod again;
mod answer;
#[cfg(feature = "command")]
mod bag;
#[cfg(feature = "command")]
mod bench;
#[cfg(feature = "command")]
mod check;
#[cfg(feature = "command")]
mod commands;
#[cfg(feature = "command")]
mod compare;
mod console;
mod context;
#[cfg(feature = "command")]
mod converge;
#[cfg(feature = "command")]
mod demo;
mod embed;
mod escape;
#[cfg(feature = "command")]
mod explain;
#[cfg(feature = "command")]
mod export;
#[cfg(feature = "command")]
mod export_arguments;
#[cfg(feature = "command")]
mod export_wheels;
mod failure;
mod fault;
mod flags;
#[cfg(feature = "command")]
mod gallery;
#[cfg(feature = "command")]
mod generate;
#[cfg(feature = "command")]
mod identify;
#[cfg(feature = "command")]
mod inspect;
#[cfg(feature = "command")]
mod interrupt;
mod json;
mod kind;
#[cfg(feature = "command")]
mod limits;
#[cfg(all(feature = "command", feature = "live"))]
mod live;
#[cfg(feature = "command")]
mod manual;
#[cfg(feature = "command")]
mod open;
#[cfg(feature = "command")]
mod options;
#[cfg(feature = "command")]
mod outcome;
mod output;
#[cfg(feature = "command")]
mod planners;
#[cfg(feature = "command")]
mod progress;
#[cfg(feature = "command")]
mod report;
mod reserve;
mod results;
#[cfg(feature = "command")]
mod robot;
#[cfg(feature = "command")]
mod ros2;
#[cfg(feature = "command")]
mod run;
#[cfg(feature = "command")]
mod schema;
#[cfg(feature = "command")]
mod sweep;
mod table;

#[cfg(feature = "command")]
pub use commands::{main, run_arguments};
pub use embed::{
    Explained, explain, generated, report_html, study_page, study_words, write_results,
};
pub use failure::Failure;
#[cfg(feature = "command")]
pub use interrupt::end_on_signals;
pub use results::{
    claim_and_write_identified, fit_tape, refuse_identify_inputs, refuse_study_inputs, write_study,
};
