//! A run of any length under way: of its rows only the last lie in memory.
//!
//! A [`Recording`] takes rows as they come. Once there are more than [`ROWS_A_GROUP`] they go into the trace's file, group
//! by group. That file can be read only when it is whole; until then [`parts`](crate::parts) hold the same rows, so that a
//! run which is stopped, however, leaves them. What comes of it is [`Recorded`]: a short run lies in memory as it always
//! did, a long one is gone through in its file.

use std::fs::File;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::error::TraceError;
use crate::file::{ROWS_A_GROUP, TraceFile, TraceWriter, write_atomically};
use crate::parts::Parts;
use crate::rows::{Rows, Which};
use crate::trace::{Header, Trace};

/// The rows of a run under way.
#[derive(Debug)]
pub struct Recording {
    /// Rows that are not in the file yet.
    recent: Trace,
    /// How many of them stand in parts.
    kept: usize,
    place: Place,
    /// The file, once it is needed.
    writer: Option<TraceWriter>,
}

/// Where rows go that are too many for memory.
#[derive(Debug)]
enum Place {
    /// Into the file that is wanted, and on the way into parts.
    Kept { path: PathBuf, parts: Parts },
    /// Into a folder that is made when it is needed and goes with the recording.
    Temporary(Option<TempDir>),
}

impl Recording {
    /// A recording that becomes the trace file `path` and stands in parts in the folder `parts`, beside it, until then.
    ///
    /// # Errors
    /// Like [`Parts::begin`].
    pub fn into_file(header: Header, path: PathBuf, parts: PathBuf) -> Result<Self, TraceError> {
        let parts = Parts::begin(parts)?;
        Ok(Self::new(header, Place::Kept { path, parts }))
    }

    /// A recording that leaves no file. One that is too long for memory goes through the system's folder of temporary
    /// files.
    pub fn temporary(header: Header) -> Self {
        Self::new(header, Place::Temporary(None))
    }

    fn new(header: Header, place: Place) -> Self {
        Self {
            recent: Trace::with_capacity(header, ROWS_A_GROUP + 1),
            kept: 0,
            place,
            writer: None,
        }
    }

    /// How many rows it holds in memory: never more than [`ROWS_A_GROUP`].
    pub fn rows_in_memory(&self) -> usize {
        self.recent.row_count()
    }

    /// Takes the rows out of a trace, which is empty after that.
    ///
    /// # Errors
    /// [`TraceError::Io`], [`TraceError::Encode`] where they had to go into a file and could not.
    pub fn take(&mut self, rows: &mut Trace) -> Result<(), TraceError> {
        self.recent.append(rows);
        rows.clear();
        while self.recent.row_count() > ROWS_A_GROUP {
            // In the file they cannot be read before it is whole.
            self.keep()?;
            let writer = match &mut self.writer {
                Some(writer) => writer,
                none => none.insert(self.place.begin(&self.recent.header)?),
            };
            writer.write_group(&self.recent, 0..ROWS_A_GROUP)?;
            self.recent.forget(ROWS_A_GROUP);
            self.kept = self.kept.saturating_sub(ROWS_A_GROUP);
        }
        Ok(())
    }

    /// Writes the rows that have come since the last time as a part, if the recording has parts.
    ///
    /// # Errors
    /// Like [`Parts::write`].
    pub fn keep(&mut self) -> Result<(), TraceError> {
        let rows = self.recent.row_count();
        if let Place::Kept { parts, .. } = &mut self.place
            && rows > self.kept
        {
            parts.write(&self.recent.rows(self.kept..rows))?;
        }
        self.kept = rows;
        Ok(())
    }

    /// Ends the recording: its file is whole then, and its parts are gone.
    ///
    /// # Errors
    /// [`TraceError::Io`], [`TraceError::Encode`] where the file cannot be written.
    pub fn finish(self) -> Result<Recorded, TraceError> {
        let Self {
            recent,
            mut place,
            writer,
            ..
        } = self;
        let path = place.path();
        let is_long = writer.is_some();
        if let Some(mut writer) = writer {
            writer.write_group(&recent, 0..recent.row_count())?;
            writer.finish()?;
        } else if let Some(path) = &path {
            recent.write_parquet(path)?;
        }
        let folder = match place {
            Place::Kept { parts, .. } => {
                parts.remove()?;
                None
            }
            Place::Temporary(folder) => folder,
        };
        match path {
            Some(path) if is_long => {
                Ok(Recorded::File(TraceFile::open(&path)?.with_folder(folder)))
            }
            _ => Ok(Recorded::Memory(recent)),
        }
    }
}

impl Place {
    /// Begins the file.
    fn begin(&mut self, header: &Header) -> Result<TraceWriter, TraceError> {
        let (path, growing) = match self {
            // Among the parts, where what a stopped run leaves is looked for, and removed by the next.
            Self::Kept { path, parts } => (path.clone(), parts.folder().join("whole.unfinished")),
            Self::Temporary(folder) => {
                let made = TempDir::with_prefix("ilon-").map_err(|source| TraceError::Io {
                    doing: "create a folder in",
                    path: std::env::temp_dir(),
                    source,
                })?;
                let path = made.path().join("trace.parquet");
                *folder = Some(made);
                (path.clone(), path.with_extension("unfinished"))
            }
        };
        TraceWriter::begin(&path, growing, header)
    }

    /// Where the file is or will be; `None` where none is needed.
    fn path(&mut self) -> Option<PathBuf> {
        match self {
            Self::Kept { path, .. } => Some(path.clone()),
            Self::Temporary(folder) => folder
                .as_ref()
                .map(|folder| folder.path().join("trace.parquet")),
        }
    }
}

/// A finished recording.
#[derive(Debug)]
pub enum Recorded {
    /// A short one, in memory.
    Memory(Trace),
    /// A long one, in its file.
    File(TraceFile),
}

impl Recorded {
    /// What was recorded earlier, in its file.
    ///
    /// # Errors
    /// Like [`TraceFile::open`].
    pub fn open(path: &Path) -> Result<Self, TraceError> {
        Ok(Self::File(TraceFile::open(path)?))
    }

    /// Writes the trace as a Parquet file of its own. The file appears whole or not at all.
    ///
    /// # Errors
    /// Like [`Trace::write_parquet`].
    pub fn write_parquet(&self, path: &Path) -> Result<(), TraceError> {
        match self {
            Self::Memory(trace) => trace.write_parquet(path),
            Self::File(file) => write_atomically(path, |copy| {
                File::open(file.path())
                    .and_then(|mut file| std::io::copy(&mut file, copy))
                    .map(|_| ())
                    .map_err(|source| TraceError::Io {
                        doing: "write",
                        path: path.to_owned(),
                        source,
                    })
            }),
        }
    }
}

impl Rows for Recorded {
    type Error = TraceError;

    fn header(&self) -> &Header {
        match self {
            Self::Memory(trace) => trace.header(),
            Self::File(file) => file.header(),
        }
    }

    fn row_count(&self) -> usize {
        match self {
            Self::Memory(trace) => trace.row_count(),
            Self::File(file) => file.row_count(),
        }
    }

    fn each_chunk(&self, which: Which, see: &mut dyn FnMut(&Trace)) -> Result<(), TraceError> {
        match self {
            Self::Memory(trace) => {
                let Ok(()) = trace.each_chunk(which, see);
                Ok(())
            }
            Self::File(file) => file.each_chunk(which, see),
        }
    }

    fn each_value(&self, signal: &str, see: &mut dyn FnMut(Option<f64>)) -> Result<(), TraceError> {
        match self {
            Self::Memory(trace) => {
                let Ok(()) = trace.each_value(signal, see);
                Ok(())
            }
            Self::File(file) => file.each_value(signal, see),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::{Settings, Summary};
    use crate::sample::made_up_trace;

    /// Hands a trace over a few rows at a time, as a run does; gives the most rows that lay in memory at once.
    fn record(recording: &mut Recording, whole: &Trace) -> usize {
        let mut most = 0;
        for first in (0..whole.row_count()).step_by(100) {
            recording.take(&mut whole.rows(first..first + 100)).unwrap();
            most = most.max(recording.rows_in_memory());
            if first % 1000 == 0 {
                recording.keep().unwrap();
            }
        }
        most
    }

    #[test]
    fn rows_in_memory_do_not_grow_with_the_length_of_a_run() {
        let whole = made_up_trace(1, 5 * ROWS_A_GROUP, false);
        let mut recording = Recording::temporary(whole.header.clone());
        let most = record(&mut recording, &whole);
        assert_eq!(most, ROWS_A_GROUP);
        let recorded = recording.finish().unwrap();
        let mut largest_chunk = 0;
        recorded
            .each_chunk(Which::All, &mut |chunk| {
                largest_chunk = largest_chunk.max(chunk.row_count());
            })
            .unwrap();
        assert_eq!(largest_chunk, ROWS_A_GROUP);
    }

    #[rstest::rstest]
    #[case::short(ROWS_A_GROUP)]
    #[case::long(2 * ROWS_A_GROUP + 77)]
    fn a_recording_is_the_trace_that_memory_would_have_held(#[case] rows: usize) {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let whole = made_up_trace(3, rows, true);
        whole.write_parquet(&at("expected.parquet")).unwrap();
        let header = || whole.header.clone();
        let mut kept =
            Recording::into_file(header(), at("trace.parquet"), at("trace.partial")).unwrap();
        let mut temporary = Recording::temporary(header());
        for recording in [&mut kept, &mut temporary] {
            record(recording, &whole);
        }
        let recorded = [kept.finish().unwrap(), temporary.finish().unwrap()];
        recorded[1].write_parquet(&at("copy.parquet")).unwrap();
        let file = |name: &str| std::fs::read(at(name)).unwrap();
        assert!(file("trace.parquet") == file("expected.parquet"));
        assert!(file("copy.parquet") == file("expected.parquet"));
        assert!(!at("trace.partial").exists());

        let settings = Settings::default();
        let expected = Summary::of(&whole, &settings);
        for recorded in &recorded {
            assert_eq!(Summary::of_rows(recorded, &settings).unwrap(), expected);
        }
    }

    #[test]
    fn a_recording_that_is_dropped_leaves_all_that_was_kept_and_no_trace_that_looks_whole() {
        let folder = tempfile::tempdir().unwrap();
        let (path, parts) = (
            folder.path().join("trace.parquet"),
            folder.path().join("trace.partial"),
        );
        let whole = made_up_trace(2, ROWS_A_GROUP + 150, true);
        let mut recording =
            Recording::into_file(whole.header.clone(), path.clone(), parts.clone()).unwrap();
        record(&mut recording, &whole);
        drop(recording);
        assert!(!path.exists());
        // The group went into parts before it went into the file; of the rows after it none was kept.
        let left = Trace::read_parquet(&parts).unwrap();
        assert!(left.row_count() > ROWS_A_GROUP);
        assert_eq!(left, whole.rows(0..left.row_count()));
    }

    #[test]
    fn a_long_temporary_recording_takes_its_files_with_it() {
        let whole = made_up_trace(1, ROWS_A_GROUP + 1, false);
        let mut recording = Recording::temporary(whole.header.clone());
        record(&mut recording, &whole);
        let recorded = recording.finish().unwrap();
        let Recorded::File(file) = &recorded else {
            panic!("it is too long for memory");
        };
        let path = file.path().to_owned();
        assert!(path.exists());
        drop(recorded);
        assert!(!path.parent().unwrap().exists());
    }
}
