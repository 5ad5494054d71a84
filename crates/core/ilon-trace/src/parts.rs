//! A growing trace as a folder of Parquet files, each a complete trace of some rows.
//!
//! The table of contents of a Parquet file is at its end, so a truncated file is unreadable. A
//! growing trace is therefore written as many small files, each of which appears complete or not at
//! all. If the writer stops, all rows up to the last part can be read by [`Trace::read_parquet`]
//! and by other Parquet readers (`trace.partial/*.parquet`).

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::TraceError;
use crate::file::{LOCK, Listing, OutputLock, Passing, io_error, is_unfinished};
use crate::trace::Trace;

/// The parts of a growing trace. Their folder is locked, so that no other trace grows in it.
#[derive(Debug)]
pub struct Parts {
    folder: PathBuf,
    parts: usize,
    _lock: OutputLock,
    /// In the end, and by an interrupted process, the folder is removed, unless parts stand in it.
    _passing: Passing,
}

impl Parts {
    /// Begins with an empty folder; parts of an earlier writer are removed.
    ///
    /// # Errors
    /// [`TraceError::Io`] if the folder cannot be created or emptied, [`TraceError::InUse`] if
    /// another trace grows in it, [`TraceError::Foreign`] if it contains something that no such
    /// writer leaves.
    pub fn begin(folder: PathBuf) -> Result<Self, TraceError> {
        let listing = Listing::open();
        fs::create_dir_all(&folder).map_err(io_error("create", &folder))?;
        let passing = listing.add(folder.clone());
        refuse_foreign(&folder)?;
        let lock = OutputLock::of_folder(&folder)?;
        remove_parts(&folder)?;
        Ok(Self {
            folder,
            parts: 0,
            _lock: lock,
            _passing: passing,
        })
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

    /// The folder of the parts.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Removes the parts after the whole trace has been written elsewhere.
    ///
    /// # Errors
    /// [`TraceError::Io`].
    pub fn remove(self) -> Result<(), TraceError> {
        remove_parts(&self.folder)
    }
}

/// Reads the parts in a folder as one trace.
///
/// # Errors
/// Like [`Trace::read_parquet`]; [`TraceError::NoParts`] without any.
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

/// Refuses a folder with anything but parts, because it will be emptied.
fn refuse_foreign(folder: &Path) -> Result<(), TraceError> {
    for entry in fs::read_dir(folder).map_err(io_error("read", folder))? {
        let entry = entry.map_err(io_error("read", folder))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_file || !(is_part(&name) || is_unfinished(&name) || name == LOCK) {
            return Err(TraceError::Foreign { path: entry.path() });
        }
    }
    Ok(())
}

fn remove_parts(folder: &Path) -> Result<(), TraceError> {
    for path in paths(folder)? {
        fs::remove_file(&path).map_err(io_error("remove", &path))?;
    }
    Ok(())
}

/// Whether a file name is that of a part.
fn is_part(name: &str) -> bool {
    name.strip_suffix(".parquet")
        .is_some_and(|number| number.len() >= 7 && number.bytes().all(|b| b.is_ascii_digit()))
}

/// The parts in a folder, in order. Unfinished ones have another, hidden name.
fn paths(folder: &Path) -> Result<Vec<PathBuf>, TraceError> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(io_error("read", folder))? {
        let path = entry.map_err(io_error("read", folder))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if is_part(&name) {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
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
        let three_and_their_lock = 4;
        assert_eq!(fs::read_dir(&path).unwrap().count(), three_and_their_lock);
        match Parts::begin(path.clone()) {
            Err(TraceError::InUse { path: taken, .. }) => assert_eq!(taken, path),
            other => panic!("{other:?}"),
        }
        drop(parts);
        // The unfinished file of a killed writer is not a part.
        fs::write(path.join(".0000003.parquet.x.ilon-partial"), b"PAR1 half").unwrap();
        assert_eq!(Trace::read_parquet(&path).unwrap(), whole);

        let fresh = Parts::begin(path.clone()).unwrap();
        let error = Trace::read_parquet(&path).unwrap_err().to_string();
        assert!(error.contains("holds no part of a trace"), "{error}");
        // Also after a failure before the first part, as on a full disk.
        drop(fresh);
        assert!(!path.exists());
        let mut again = Parts::begin(path.clone()).unwrap();
        again.write(&whole).unwrap();
        again.remove().unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn a_folder_with_other_files_in_it_is_neither_emptied_nor_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.partial");
        fs::create_dir(&path).unwrap();
        for name in ["0000000.parquet", "notes.txt"] {
            fs::write(path.join(name), "mine").unwrap();
        }
        match Parts::begin(path.clone()) {
            Err(TraceError::Foreign { path: found }) => assert_eq!(found, path.join("notes.txt")),
            other => panic!("{other:?}"),
        }
        assert_eq!(fs::read_dir(&path).unwrap().count(), 2);
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
