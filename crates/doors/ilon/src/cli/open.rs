//! `--open`: opens a page in the browser.

use std::path::Path;
use std::process::{Command, Stdio};

use super::console;

/// Opens a page; if that fails, prints its path.
pub(super) fn page(path: &Path) {
    // By its absolute path: the opener may run in another directory.
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let (program, first): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("cmd", &["/C", "start", ""])
    } else {
        ("xdg-open", &[])
    };
    let opened = Command::new(program)
        .args(first)
        .arg(&path)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    if opened.is_err() {
        console::note(&format!(
            "note: `{program}` did not start; open {} in a browser",
            path.display()
        ));
    }
}
