//! A trace that is written as it grows: a folder of Parquet files, each a whole trace of its own over some rows.
//!
//! A Parquet file has its table of contents at its end, so that one which is cut short tells nothing. A growing trace is
//! therefore written as many small files, each of which appears whole or not at all; whatever stops the writer, all rows
//! up to the last part can be read, by [`Trace::read_parquet`] and by whatever else reads Parquet
//! (`trace.partial/*.parquet`).

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::TraceError;
use crate::trace::Trace;

/// The parts of a growing trace.
#[derive(Debug)]
pub struct Parts {
    folder: PathBuf,
    parts: usize,
}

impl Parts {
    /// Begins with an empty folder; parts that an earlier writer left there are removed.
    ///
    /// # Errors
    /// [`TraceError::Io`] where the folder cannot be made or emptied.
    pub fn begin(folder: PathBuf) -> Result<Self, TraceError> {
        remove(&folder)?;
        fs::create_dir_all(&folder).map_err(io_error("create", &folder))?;
        Ok(Self { folder, parts: 0 })
    }

    /// Writes rows, if there are any, as the next part.
    ///
    /// # Errors
    /// Like [`Trace::write_parquet`].
    pub fn write(&mut self, rows: &Trace) -> Result<(), TraceError> {
        if !rows.records().is_empty() {
            // Seven digits: a part a second for three months, in the order of their names.
            let name = format!("{:07}.parquet", self.parts);
            rows.write_parquet(&self.folder.join(name))?;
            self.parts += 1;
        }
        Ok(())
    }

    /// The folder that they stand in.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Removes the parts, once the whole trace stands elsewhere.
    ///
    /// # Errors
    /// [`TraceError::Io`].
    pub fn remove(self) -> Result<(), TraceError> {
        remove(&self.folder)
    }
}

/// Reads the parts in a folder as one trace.
///
/// # Errors
/// Like [`Trace::read_parquet`]; [`TraceError::NoParts`] where there is none.
pub(crate) fn read(folder: &Path) -> Result<Trace, TraceError> {
    let mut whole: Option<Trace> = None;
    for path in paths(folder)? {
        let part = Trace::read_parquet(&path)?;
        match &mut whole {
            None => whole = Some(part),
            Some(whole) => whole.append(&part),
        }
    }
    whole.ok_or_else(|| TraceError::NoParts {
        path: folder.to_owned(),
    })
}

/// Removes a folder of parts with all that its writer may have left there.
fn remove(folder: &Path) -> Result<(), TraceError> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(io_error("remove", folder)(error))
        }
        _ => Ok(()),
    }
}

/// The parts in a folder, in order. Half-written ones are hidden under another name.
fn paths(folder: &Path) -> Result<Vec<PathBuf>, TraceError> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(io_error("read", folder))? {
        let path = entry.map_err(io_error("read", folder))?.path();
        if path.extension().is_some_and(|ending| ending == "parquet") {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

fn io_error(doing: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> TraceError {
    let path = path.to_owned();
    move |source| TraceError::Io {
        doing,
        path,
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::made_up_trace;

    #[test]
    fn what_was_written_in_parts_is_read_as_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.partial");
        let whole = made_up_trace(3, 25, true);
        let mut parts = Parts::begin(path.clone()).unwrap();
        for rows in [0..10, 10..10, 10..11, 11..25] {
            parts.write(&whole.rows(rows)).unwrap();
        }
        assert_eq!(fs::read_dir(&path).unwrap().count(), 3);
        // What a writer that was killed in the middle of a part leaves behind is no part.
        fs::write(path.join(".0000003.parquet.1.partial"), b"PAR1 half").unwrap();
        assert_eq!(Trace::read_parquet(&path).unwrap(), whole);

        let fresh = Parts::begin(path.clone()).unwrap();
        let error = Trace::read_parquet(&path).unwrap_err().to_string();
        assert!(error.contains("holds no part of a trace"), "{error}");
        fresh.remove().unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn each_part_is_a_trace_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.partial");
        let whole = made_up_trace(4, 9, false);
        let mut parts = Parts::begin(path.clone()).unwrap();
        parts.write(&whole.rows(0..4)).unwrap();
        parts.write(&whole.rows(4..9)).unwrap();
        let second = Trace::read_parquet(&path.join("0000001.parquet")).unwrap();
        assert_eq!(second, whole.rows(4..9));
        assert_eq!(second.records()[0], whole.records()[4]);
    }
}
