//! A run of any length under way: of its rows only the last lie in memory.
//!
//! A [`Recording`] takes rows as they come. Once there are more than [`ROWS_A_GROUP`] they go into the trace's file, group
//! by group. That file can be read only when it is whole; until then [`parts`](crate::parts) hold the same rows, so that a
//! run which is stopped, however, leaves them. What comes of it is [`Recorded`]: a short run lies in memory as it always
//! did, a long one is gone through in its file.

use std::path::{Path, PathBuf};

use crate::error::TraceError;
use crate::file::{ROWS_A_GROUP, TraceFile, TraceWriter, io_error, write_atomically};
use crate::finite::Watched;
use crate::header::Header;
use crate::parts::Parts;
use crate::rows::Rows;
use crate::trace::Trace;
use crate::twin::Twin;

/// The rows of a run under way.
#[derive(Debug)]
pub struct Recording {
    /// Rows that are not in the file yet.
    recent: Trace,
    /// How many of them stand in parts.
    kept: usize,
    /// What must be finite.
    watched: Watched,
    place: RowStore,
    /// The file, once it is needed.
    writer: Option<TraceWriter>,
}

/// Where rows go that are too many for memory.
#[derive(Debug)]
enum RowStore {
    /// Into the file that is wanted, and on the way into parts.
    Kept { path: PathBuf, parts: Parts },
    /// Into a file without a name among the system's temporary ones, made when it is needed: it goes with the recording, and
    /// with the process however that ends.
    Temporary,
}

impl Recording {
    /// A recording that becomes the trace file `path` and stands in parts in the folder `parts`, beside it, until then.
    ///
    /// # Errors
    /// Like [`Parts::begin`].
    pub fn into_file(header: Header, path: PathBuf, parts: PathBuf) -> Result<Self, TraceError> {
        let parts = Parts::begin(parts)?;
        Ok(Self::new(header, RowStore::Kept { path, parts }))
    }

    /// A recording that leaves no file. One that is too long for memory goes through the system's folder of temporary
    /// files.
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

    /// How many rows it holds in memory: never more than [`ROWS_A_GROUP`].
    pub fn rows_in_memory(&self) -> usize {
        self.recent.row_count()
    }

    /// Takes the rows out of a trace, which is empty after that.
    ///
    /// # Errors
    /// [`TraceError::Io`], [`TraceError::Encode`] where they had to go into a file and could not;
    /// [`TraceError::Diverged`] where they hold something that is no number.
    pub fn take(&mut self, rows: &mut Trace) -> Result<(), TraceError> {
        let before = self.recent.row_count();
        self.recent.append(rows);
        rows.clear();
        self.watched
            .check(&self.recent, before..self.recent.row_count())?;
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

    /// Adds to the header what became of the run's twins: it is written when the recording is finished.
    pub fn add_twins(&mut self, twins: Vec<Twin>) {
        self.recent.header.twins.extend(twins);
    }

    /// Writes the rows that have come since the last time as a part, if the recording has parts.
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

    /// Ends the recording: its file is whole then, and its parts are gone.
    ///
    /// # Errors
    /// [`TraceError::Io`], [`TraceError::Encode`] where the file cannot be written.
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
            // Among the parts, where what a stopped run leaves is looked for, and removed by the next.
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
        // The group went into parts before it went into the file; of the rows after it none was kept.
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
