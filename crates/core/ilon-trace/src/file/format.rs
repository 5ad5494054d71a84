//! Constants of the trace file's format.

/// Rows per group of the file: the part of a long trace that is in memory while it is written or
/// read.
pub const ROWS_A_GROUP: usize = 8192;

/// The most rows of a trace: about ten gigabytes, and a day at 100 Hz. Chosen.
pub const MOST_ROWS: usize = 10_000_000;

/// The key of the header among the file's key-value metadata.
pub const HEADER_KEY: &str = "ilon.trace.header";
