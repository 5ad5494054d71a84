//! What many runs, or logs, come to, in sentences and tables: the terminal prints what the page shows.

pub mod identify;
pub mod sweep;
