//! The trace as a Parquet file: one row per control step, columns named with their units, the
//! header as JSON under [`HEADER_KEY`] in the key-value metadata. pandas, polars and DuckDB read it
//! directly.
//!
//! After the first four bytes of a file comes a checksum of the whole file, in a place that Parquet
//! readers skip: a damaged trace is refused, not read.
//!
//! Rows are in groups of [`ROWS_A_GROUP`], so that a long trace can be written while it grows
//! ([`TraceWriter`]) and read ([`TraceFile`]) without being in memory as a whole.

mod atomic;
mod checksum;
mod format;
mod lock;
mod passing;
mod read;
mod write;

use std::io::{Cursor, Seek, Write};
use std::path::Path;

pub use atomic::{clear_unfinished, is_stream, write_atomically, write_bytes, write_text};
pub use format::{HEADER_KEY, MOST_ROWS, ROWS_A_GROUP};
pub use lock::OutputLock;
pub use passing::discard_unfinished;
pub use read::TraceFile;
pub use write::TraceWriter;

pub(crate) use atomic::{io_error, is_unfinished};
pub(crate) use lock::LOCK;
pub(crate) use passing::{Listing, Passing};

use crate::error::TraceError;
use crate::rows::Rows;
use crate::trace::Trace;

/// Whether a file is a trace, complete or not; only a few bytes of it are read.
pub fn is_trace(path: &Path) -> bool {
    let file = ilon_files::FileAccess::anywhere().open(path);
    file.is_ok_and(|mut file| checksum::is_labelled(&mut file).unwrap_or(false))
}

impl Trace {
    /// Writes the trace as a Parquet file. The file appears complete or not at all.
    ///
    /// # Errors
    /// [`TraceError::Io`] if the file cannot be written, [`TraceError::TooManyTasks`].
    pub fn write_parquet(&self, path: &Path) -> Result<(), TraceError> {
        let mut writer = TraceWriter::begin(path, atomic::folder_of(path), &self.header)?;
        self.write_groups(&mut writer)?;
        writer.finish(&self.header)
    }

    /// The bytes of the file that [`Self::write_parquet`] writes, for systems without files.
    ///
    /// # Errors
    /// [`TraceError::TooManyTasks`].
    pub fn to_parquet(&self) -> Result<Vec<u8>, TraceError> {
        let mut writer = TraceWriter::begin_into(Cursor::new(Vec::new()), &self.header)?;
        self.write_groups(&mut writer)?;
        writer.end(&self.header).map(Cursor::into_inner)
    }

    fn write_groups<W: Write + Seek + Send>(
        &self,
        writer: &mut TraceWriter<W>,
    ) -> Result<(), TraceError> {
        let rows = self.records().len();
        for group in 0..rows.div_ceil(ROWS_A_GROUP).max(1) {
            let first = group * ROWS_A_GROUP;
            writer.write_group(self, first..(first + ROWS_A_GROUP).min(rows))?;
        }
        Ok(())
    }

    /// Reads a trace back from its file, bit for bit, or from a folder of [`crate::parts`].
    ///
    /// # Errors
    /// Names the file that is missing, broken, damaged or not a trace, or the missing column.
    pub fn read_parquet(path: &Path) -> Result<Self, TraceError> {
        if path.is_dir() {
            return crate::parts::read(path);
        }
        let file = TraceFile::open(path)?;
        let mut trace = Self::with_capacity(file.header().clone(), file.row_count());
        file.each_batch(&mut |chunk| trace.append(chunk))?;
        Ok(trace)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use super::*;
    use crate::sample::made_up_trace;

    /// A folder for one test, removed at the end.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path =
                std::env::temp_dir().join(format!("ilon-trace-{name}-{}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test_case::test_case(true; "closed loop")]
    #[test_case::test_case(false; "open loop")]
    fn a_trace_comes_back_from_its_file_bit_for_bit(closed_loop: bool) {
        let folder = Folder::new(if closed_loop { "closed" } else { "open" });
        let path = folder.0.join("trace.parquet");
        // More steps than one page of the file holds.
        let trace = made_up_trace(3, 30_000, closed_loop);
        trace.write_parquet(&path).unwrap();
        assert!(trace.to_parquet().unwrap() == fs::read(&path).unwrap());
        let back = Trace::read_parquet(&path).unwrap();
        assert_eq!(back, trace);
        assert_eq!(crate::trace_hash(&back), crate::trace_hash(&trace));
        let names: Vec<_> = fs::read_dir(&folder.0)
            .unwrap()
            .map(|e| e.unwrap().file_name())
            .collect();
        assert_eq!(
            names,
            ["trace.parquet"],
            "nothing else is left in the folder"
        );
    }

    #[test]
    fn a_file_that_is_no_trace_is_refused_with_what_it_is_instead() {
        let folder = Folder::new("refused");
        let path = folder.0.join("trace.parquet");
        let shown = path.display();

        let missing = Trace::read_parquet(&path).unwrap_err().to_string();
        assert!(
            missing.starts_with(&format!("cannot read `{shown}`: ")),
            "{missing}"
        );

        fs::write(&path, "t_s,truth_x_m\n0,0\n").unwrap();
        let text = Trace::read_parquet(&path).unwrap_err().to_string();
        assert!(
            text.starts_with(&format!("`{shown}` cannot be read as Parquet")),
            "{text}"
        );

        assert!(!is_trace(&path));
        made_up_trace(3, 200, true).write_parquet(&path).unwrap();
        assert!(is_trace(&path) && !is_trace(&folder.0));
        let whole = fs::read(&path).unwrap();
        fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        let cut = Trace::read_parquet(&path).unwrap_err().to_string();
        assert_eq!(
            cut,
            format!(
                "the trace `{shown}` is damaged or cut short: its checksum is wrong; run the scenario again"
            )
        );

        // Written by another program: other bytes between the Parquet marks.
        fs::write(&path, b"PAR1 others PAR1").unwrap();
        let foreign = Trace::read_parquet(&path).unwrap_err().to_string();
        assert_eq!(
            foreign,
            format!("`{shown}` is a Parquet file, but not a trace of ilon")
        );
    }

    #[test]
    fn a_file_with_a_flipped_bit_is_refused() {
        let folder = Folder::new("flipped");
        let path = folder.0.join("trace.parquet");
        let trace = made_up_trace(1, 6, true);
        trace.write_parquet(&path).unwrap();
        let whole = fs::read(&path).unwrap();
        // Covers every bit position and every part of the file; testing all bits would take a
        // minute.
        for bit in (0..8 * whole.len()).step_by(211) {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, &flipped).unwrap();
            assert!(Trace::read_parquet(&path).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn a_broken_file_whose_checksum_was_made_to_fit_is_refused_or_read_and_nothing_worse() {
        let folder = Folder::new("sealed");
        let path = folder.0.join("trace.parquet");
        let trace = made_up_trace(1, 6, true);
        trace.write_parquet(&path).unwrap();
        let whole = fs::read(&path).unwrap();
        let (mut refused, mut read) = (0, 0);
        for bit in (8 * 52..8 * whole.len()).step_by(211) {
            let mut broken = whole.clone();
            broken[bit / 8] ^= 1 << (bit % 8);
            checksum::seal(&mut broken);
            fs::write(&path, &broken).unwrap();
            match Trace::read_parquet(&path) {
                Ok(_) => read += 1,
                Err(_) => refused += 1,
            }
        }
        assert!(refused > 0 && read > 0, "{refused} refused, {read} read");
    }

    /// A renamed column is reported as missing.
    #[test]
    fn a_column_that_is_not_there_is_named() {
        let folder = Folder::new("older");
        let path = folder.0.join("trace.parquet");
        let trace = made_up_trace(1, 6, true);
        trace.write_parquet(&path).unwrap();
        let whole = fs::read(&path).unwrap();
        let without = |names: &[&str]| {
            let mut renamed = whole.clone();
            for name in names {
                let length = name.len();
                let places: Vec<usize> = (0..renamed.len() - length)
                    .filter(|&at| &renamed[at..at + length] == name.as_bytes())
                    .collect();
                assert!(!places.is_empty(), "{name}");
                places.into_iter().for_each(|at| renamed[at] = b'X');
            }
            checksum::seal(&mut renamed);
            fs::write(&path, &renamed).unwrap();
            Trace::read_parquet(&path)
        };
        for name in ["desired_x_m", "wheels_load_n"] {
            let error = without(&[name]).unwrap_err().to_string();
            assert!(error.contains(name), "{error}");
        }
    }

    #[test]
    fn a_trace_that_cannot_be_written_leaves_nothing_behind() {
        let folder = Folder::new("unwritable");
        // The file's path is taken by a folder.
        let path = folder.0.join("trace.parquet");
        fs::create_dir(&path).unwrap();
        let error = made_up_trace(3, 2, true).write_parquet(&path).unwrap_err();
        let expected = format!("cannot write `{}`: ", path.display());
        assert!(error.to_string().starts_with(&expected), "{error}");
        assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 1);
    }
}
