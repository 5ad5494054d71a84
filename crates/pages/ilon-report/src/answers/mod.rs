//! Results of many runs, or logs, in sentences and tables, for the terminal and the page.

pub mod identify;
pub mod sweep;
