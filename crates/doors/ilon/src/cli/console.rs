//! The one door to standard output and standard error.
//!
//! What goes to standard error is for whoever watches: if nobody does, or the disk behind it is full, the command goes on
//! and its results count. What goes to standard output is a result itself.

use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use super::escape;
use crate::cli::failure::Failure;

/// Whether [`lines`] and [`note`] print nothing: the two streams are the whole process's, and so is what goes to them.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From here on [`lines`] and [`note`] print nothing, or do so again.
pub(super) fn be_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// Whether nothing is printed but faults, what did not hold, and data.
pub(super) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Data to standard output, as it is. A reader that has gone away, such as `head`, ends the writing without a fault.
///
/// # Errors
/// Where it cannot be written, such as to a full disk.
pub(super) fn data(text: &str) -> Result<(), Failure> {
    written(io::stdout().lock().write_all(text.as_bytes()))
}

/// What came of writing to standard output, all of it handed over.
///
/// # Errors
/// Like [`data`].
pub(super) fn written(result: io::Result<()>) -> Result<(), Failure> {
    match result.and_then(|()| io::stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::usage(
            format!(
                "cannot write to standard output: {}",
                ilon_sim::reason(&error)
            ),
            "check where it goes: is the disk full? Result files that were written before are complete",
        )),
        _ => Ok(()),
    }
}

/// Lines for a person to standard output; none when quiet.
///
/// # Errors
/// Like [`data`].
pub(super) fn lines(text: &str) -> Result<(), Failure> {
    if is_quiet() { Ok(()) } else { failed(text) }
}

/// Lines for a person to standard output, when quiet too: what did not hold.
///
/// # Errors
/// Like [`data`].
pub(super) fn failed(text: &str) -> Result<(), Failure> {
    data(&escape::lines(text))
}

/// A line for whoever watches, to standard error; none when quiet.
pub(super) fn note(text: &str) {
    if !is_quiet() {
        watching(&format!("{}\n", escape::lines(text)));
    }
}

/// Text that is escaped already, to standard error.
pub(super) fn watching(text: &str) {
    // In one piece, so that lines of several threads do not mix.
    let mut stderr = io::stderr().lock();
    let _ = stderr
        .write_all(text.as_bytes())
        .and_then(|()| stderr.flush());
}
