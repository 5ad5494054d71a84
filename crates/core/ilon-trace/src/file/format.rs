//! What the file of a trace is called and divided by.

/// Rows of the file that stand together: what is held of a long trace at a time when it is written or gone through.
pub const ROWS_A_GROUP: usize = 8192;

/// The most rows of a trace: ten gigabytes or so, and a day at 100 Hz.
pub const MOST_ROWS: usize = 10_000_000;

/// The key of the header among the file's key-value metadata.
pub const HEADER_KEY: &str = "ilon.trace.header";
