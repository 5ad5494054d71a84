//! The one door to standard output and standard error.
//!
//! What goes to standard error is for whoever watches: if nobody does, or the disk behind it is full, the command goes on
//! and its results count. What goes to standard output is a result itself.

use std::io::{self, ErrorKind, Write};

use super::escape;
use crate::cli::failure::Failure;

/// Data to standard output, as it is. A reader that has gone away, such as `head`, ends the writing without a fault.
///
/// # Errors
/// Where it cannot be written, such as to a full disk.
pub(super) fn data(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    let written = stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush());
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::usage(
            format!(
                "cannot write to standard output: {}",
                ilon_sim::reason(&error)
            ),
            "see to what it leads to, such as a disk that is full; files of results that were written before are whole",
        )),
        _ => Ok(()),
    }
}

/// Lines for a person to standard output.
///
/// # Errors
/// Like [`data`].
pub(super) fn lines(text: &str) -> Result<(), Failure> {
    data(&escape::lines(text))
}

/// A line for whoever watches, to standard error.
pub(super) fn note(text: &str) {
    watching(&format!("{}\n", escape::lines(text)));
}

/// Text that is escaped already, to standard error.
pub(super) fn watching(text: &str) {
    // In one piece, so that lines of several threads do not mix.
    let mut stderr = io::stderr().lock();
    let _ = stderr
        .write_all(text.as_bytes())
        .and_then(|()| stderr.flush());
}
