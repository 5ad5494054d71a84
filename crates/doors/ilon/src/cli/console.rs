//! All writing to standard output and standard error.
//!
//! Standard error carries messages for the user: if it is closed or its disk is full, the command
//! continues and its results count. Standard output carries results.

use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use super::escape;
use crate::cli::failure::Failure;

/// Whether [`lines`] and [`note`] print nothing. Global, as the two streams are.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Sets whether [`lines`] and [`note`] print nothing.
pub(super) fn be_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// Whether only errors, failed expectations and data are printed.
pub(super) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Writes data unchanged to standard output. A reader that closes the pipe, such as `head`, ends
/// the writing without an error.
///
/// # Errors
/// If writing fails, such as on a full disk.
pub(super) fn data(text: &str) -> Result<(), Failure> {
    written(io::stdout().lock().write_all(text.as_bytes()))
}

/// Converts the result of writing to standard output, and flushes.
///
/// # Errors
/// As [`data`].
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

/// Writes lines for the user to standard output; nothing if quiet.
///
/// # Errors
/// As [`data`].
pub(super) fn lines(text: &str) -> Result<(), Failure> {
    if is_quiet() { Ok(()) } else { failed(text) }
}

/// Writes lines about failed expectations to standard output, also if quiet.
///
/// # Errors
/// As [`data`].
pub(super) fn failed(text: &str) -> Result<(), Failure> {
    data(&escape::lines(text))
}

/// Writes a line for the user to standard error; nothing if quiet.
pub(super) fn note(text: &str) {
    if !is_quiet() {
        watching(&format!("{}\n", escape::lines(text)));
    }
}

/// Writes text that is already escaped to standard error.
pub(super) fn watching(text: &str) {
    // In one write, so that lines of several threads do not mix.
    let mut stderr = io::stderr().lock();
    let _ = stderr
        .write_all(text.as_bytes())
        .and_then(|()| stderr.flush());
}
