//! A run of any length in progress: only its last rows are in memory.
//!
//! A [`Recording`] takes rows as they arrive. When there are more than [`ROWS_A_GROUP`], they go
//! into the trace's file, group by group. That file is readable only when it is complete; until
//! then [`parts`](crate::parts) hold the same rows, so that an interrupted run leaves them. The
//! result is a [`Recorded`]: a short run is in memory, a long one is read from its file.

use std::path::{Path, PathBuf};

use crate::error::TraceError;
use crate::file::{ROWS_A_GROUP, TraceFile, TraceWriter, io_error, write_atomically};
use crate::finite::Watched;
use crate::header::Header;
use crate::parts::Parts;
use crate::rows::Rows;
use crate::trace::Trace;
use crate::twin::Twin;

/// The rows of a run in progress.
#[derive(Debug)]
pub struct Recording {
    /// Rows that are not in the file yet.
    recent: Trace,
    /// The number of them that are in parts.
    kept: usize,
    /// The signals that must be finite.
    watched: Watched,
    place: RowStore,
    /// The file, once it is needed.
    writer: Option<TraceWriter>,
}

/// Where rows go that do not fit into memory.
#[derive(Debug)]
enum RowStore {
    /// Into the requested file, and until it is complete into parts.
    Kept { path: PathBuf, parts: Parts },
    /// Into a nameless temporary file, created when it is needed. It vanishes with the recording,
    /// or with the process.
    Temporary,
}

impl Recording {
    /// A recording that becomes the trace file `path`, with parts in the folder `parts` beside it
    /// until then.
    ///
    /// # Errors
    /// Like [`Parts::begin`].
    pub fn into_file(header: Header, path: PathBuf, parts: PathBuf) -> Result<Self, TraceError> {
        let parts = Parts::begin(parts)?;
        Ok(Self::new(header, RowStore::Kept { path, parts }))
    }

    /// A recording that leaves no file. If it is too long for memory, it uses the system's folder
    /// of temporary files.
    pub fn temporary(header: Header) -> Self {
        Self::new(header, RowStore::Temporary)
    }

    fn new(header: Header, place: RowStore) -> Self {
        let recent = Trace::with_capacity(header, ROWS_A_GROUP + 1);
        Self {
            watched: Watched::of(&recent),
            recent,
            kept: 0,
            place,
            writer: None,
        }
    }

    /// The number of rows in memory: never more than [`ROWS_A_GROUP`].
    pub fn rows_in_memory(&self) -> usize {
        self.recent.row_count()
    }

    /// Moves the rows out of a trace, which is empty afterwards.
    ///
    /// # Errors
    /// [`TraceError::Io`], [`TraceError::Encode`] if they could not be written to a file;
    /// [`TraceError::Diverged`] if they contain a non-finite value.
    pub fn take(&mut self, rows: &mut Trace) -> Result<(), TraceError> {
        let before = self.recent.row_count();
        self.recent.append(rows);
        rows.clear();
        self.watched
            .check(&self.recent, before..self.recent.row_count())?;
        while self.recent.row_count() > ROWS_A_GROUP {
            // The file is unreadable until it is complete.
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

    /// Adds the results of the run's twins to the header, which is written when the recording is
    /// finished.
    pub fn add_twins(&mut self, twins: Vec<Twin>) {
        self.recent.header.twins.extend(twins);
    }

    /// Writes the rows since the last call as a part, if the recording has parts.
    ///
    /// # Errors
    /// Like [`Parts::write`].
    pub fn keep(&mut self) -> Result<(), TraceError> {
        let rows = self.recent.row_count();
        if let RowStore::Kept { parts, .. } = &mut self.place
            && rows > self.kept
        {
            parts.write(&self.recent.rows(self.kept..rows))?;
        }
        self.kept = rows;
        Ok(())
    }

    /// Ends the recording: its file is complete, and its parts are removed.
    ///
    /// # Errors
    /// [`TraceError::Io`], [`TraceError::Encode`] if the file cannot be written.
    pub fn finish(self) -> Result<Recorded, TraceError> {
        let Self {
            recent,
            place,
            writer,
            ..
        } = self;
        let Some(mut writer) = writer else {
            if let RowStore::Kept { path, parts } = place {
                recent.write_parquet(&path)?;
                parts.remove()?;
            }
            return Ok(Recorded::Memory(recent));
        };
        writer.write_group(&recent, 0..recent.row_count())?;
        let file = writer.end(&recent.header)?;
        Ok(Recorded::File(match place {
            RowStore::Kept { path, parts } => {
                parts.remove()?;
                TraceFile::of(file, &path)?
            }
            RowStore::Temporary => TraceFile::of_nameless(file)?,
        }))
    }
}

impl RowStore {
    /// Begins the file.
    fn begin(&self, header: &Header) -> Result<TraceWriter, TraceError> {
        match self {
            // In the parts' folder, so that the next run removes what an interrupted one leaves.
            Self::Kept { path, parts } => TraceWriter::begin(path, parts.folder(), header),
            Self::Temporary => {
                let file = tempfile::tempfile();
                let file = file.map_err(io_error("create a file in", &std::env::temp_dir()))?;
                TraceWriter::begin_nameless(file, header)
            }
        }
    }
}

/// A finished recording.
#[derive(Debug)]
pub enum Recorded {
    /// A short run, in memory.
    Memory(Trace),
    /// A long run, in its file.
    File(TraceFile),
}

impl Recorded {
    /// Opens an earlier recording from its file.
    ///
    /// # Errors
    /// Like [`TraceFile::open`].
    pub fn open(path: &Path) -> Result<Self, TraceError> {
        Ok(Self::File(TraceFile::open(path)?))
    }

    /// Writes the trace as a new Parquet file, which appears complete or not at all.
    ///
    /// # Errors
    /// Like [`Trace::write_parquet`].
    pub fn write_parquet(&self, path: &Path) -> Result<(), TraceError> {
        match self {
            Self::Memory(trace) => trace.write_parquet(path),
            Self::File(file) => write_atomically(path, |copy| {
                file.copy_to(copy).map_err(io_error("write", path))?;
                Ok(())
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

    fn each_batch(&self, see: &mut dyn FnMut(&Trace)) -> Result<(), TraceError> {
        match self {
            Self::Memory(trace) => {
                let Ok(()) = trace.each_batch(see);
                Ok(())
            }
            Self::File(file) => file.each_batch(see),
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

    /// Records a trace a few rows at a time, as a run does; returns the largest number of rows in
    /// memory.
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
            .each_batch(&mut |chunk| {
                largest_chunk = largest_chunk.max(chunk.row_count());
            })
            .unwrap();
        assert_eq!(largest_chunk, ROWS_A_GROUP);
    }

    #[test_case::test_case(ROWS_A_GROUP; "short")]
    #[test_case::test_case(2 * ROWS_A_GROUP + 77; "long")]
    fn a_recording_is_the_trace_that_memory_would_have_held(rows: usize) {
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
        // The group went into parts before it went into the file; the rows after it were not kept.
        let left = Trace::read_parquet(&parts).unwrap();
        assert!(left.row_count() > ROWS_A_GROUP);
        assert_eq!(left, whole.rows(0..left.row_count()));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_long_temporary_recording_has_no_name_that_a_killed_process_could_leave() {
        let whole = made_up_trace(1, ROWS_A_GROUP + 1, false);
        let mut recording = Recording::temporary(whole.header.clone());
        record(&mut recording, &whole);
        let open = || {
            let of_process = std::fs::read_dir("/proc/self/fd").unwrap();
            let targets = of_process.filter_map(|fd| std::fs::read_link(fd.ok()?.path()).ok());
            let temporary = std::env::temp_dir();
            targets
                .filter(|target| target.starts_with(&temporary))
                .map(|target| target.to_string_lossy().into_owned())
                .collect::<Vec<_>>()
        };
        assert!(
            open().iter().any(|path| path.ends_with(" (deleted)")),
            "{:?}",
            open()
        );
        let recorded = recording.finish().unwrap();
        assert!(matches!(recorded, Recorded::File(_)));
        assert_eq!(recorded.row_count(), whole.row_count());
    }
}
