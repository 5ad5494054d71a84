//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::error::TraceError;

/// A file that is being written under another name, and is removed unless it is finished.
#[derive(Debug)]
pub(super) struct Unfinished {
    path: PathBuf,
    growing: PathBuf,
}

impl Unfinished {
    /// Begins the file `path` as `growing`, on the same file system.
    pub fn create(path: &Path, growing: PathBuf) -> Result<(Self, File), TraceError> {
        let file = File::create(&growing).map_err(io_error("create", path))?;
        let path = path.to_owned();
        Ok((Self { path, growing }, file))
    }

    /// What the file will be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its name.
    pub fn finish(self, mut file: File) -> Result<(), TraceError> {
        file.flush()
            .and_then(|()| fs::rename(&self.growing, &self.path))
            .map_err(io_error("write", &self.path))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        // Once finished it is no longer there. If it cannot be removed, the error that left it unfinished is the one to
        // tell.
        let _ = fs::remove_file(&self.growing);
    }
}

/// Writes a file beside `path` and then moves it there, so that nobody ever sees half of it.
///
/// # Errors
/// What `write` returns, or [`TraceError::Io`]; in either case `path` is as it was and nothing is left behind.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut File) -> Result<(), TraceError>,
) -> Result<(), TraceError> {
    let (unfinished, mut file) = Unfinished::create(path, partial_path(path))?;
    write(&mut file)?;
    unfinished.finish(file)
}

/// Writes text to a file so that nobody ever sees half of it.
///
/// # Errors
/// [`TraceError::Io`]; `path` is then as it was.
pub fn write_text(path: &Path, text: &str) -> Result<(), TraceError> {
    write_atomically(path, |file| {
        file.write_all(text.as_bytes())
            .map_err(io_error("write", path))
    })
}

/// A hidden neighbour of `path`, of this process alone.
pub(super) fn partial_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.partial", std::process::id()))
}

fn io_error(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> TraceError {
    let path = path.to_owned();
    move |source| TraceError::Io {
        doing,
        path,
        source,
    }
}
