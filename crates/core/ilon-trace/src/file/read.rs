//! Reading traces.

use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use ilon_files::{FileAccess, ReadError};
use parquet::column::reader::ColumnReader;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::atomic::io_error;
use super::checksum::{self, Integrity};
use super::format::{HEADER_KEY, MOST_ROWS, ROWS_A_GROUP};
use crate::columns::{ColumnType, Signal, signals};
use crate::error::TraceError;
use crate::header::Header;
use crate::record::MAX_TASKS;
use crate::rows::Rows;
use crate::trace::Trace;

/// A trace in its file. Its rows are read one group at a time, so that memory does not grow with
/// the length of the run.
pub struct TraceFile {
    path: PathBuf,
    /// A second handle on the reader's file.
    file: File,
    reader: SerializedFileReader<File>,
    header: Header,
    row_count: usize,
}

/// The most wheels of a readable trace. Chosen.
const MOST_WHEELS: usize = 1000;
/// The most rollers with recorded angles of a readable trace. Chosen.
const MOST_ROLLERS: usize = 100_000;

impl TraceFile {
    /// Opens a trace after checking the whole file against its checksum, and reads its header.
    ///
    /// # Errors
    /// If the file is missing, broken, damaged, or not a trace.
    pub fn open(path: &Path) -> Result<Self, TraceError> {
        let file = FileAccess::anywhere().open(path).map_err(|fault| {
            let source = match fault {
                ReadError::Io(source) => source,
                other => std::io::Error::other(other.to_string()),
            };
            io_error("read", path)(source)
        })?;
        let mut own = file.try_clone().map_err(io_error("read", path))?;
        // The Parquet reader does not survive every broken file, so it sees only intact ones.
        let found = checksum::check(&mut own).map_err(io_error("read", path))?;
        let path_owned = path.to_owned();
        match found {
            Integrity::Whole => Self::of(file, path),
            Integrity::Damaged => Err(TraceError::Damaged { path: path_owned }),
            Integrity::Parquet => Err(TraceError::NotATrace { path: path_owned }),
            Integrity::Other => Err(TraceError::NotParquet {
                path: path_owned,
                source: ParquetError::General("it does not begin and end as one".to_owned()),
            }),
        }
    }

    /// A trace in a file without a name.
    pub(crate) fn of_nameless(file: File) -> Result<Self, TraceError> {
        Self::of(file, &std::env::temp_dir())
    }

    /// A trace in a file that is known to be intact.
    pub(crate) fn of(file: File, path: &Path) -> Result<Self, TraceError> {
        shielded(path, || Self::parse(file, path))
    }

    fn parse(file: File, path: &Path) -> Result<Self, TraceError> {
        let not_parquet = |source| TraceError::NotParquet {
            path: path.to_owned(),
            source,
        };
        let own = file.try_clone().map_err(io_error("read", path))?;
        let reader = SerializedFileReader::new(file).map_err(not_parquet)?;
        let json = metadata(&reader, HEADER_KEY).ok_or_else(|| TraceError::NotATrace {
            path: path.to_owned(),
        })?;
        let header = read_header(json, path)?;
        let row_count = rows_of(&reader, &header).ok_or_else(|| TraceError::Damaged {
            path: path.to_owned(),
        })?;
        Ok(Self {
            path: path.to_owned(),
            file: own,
            reader,
            header,
            row_count,
        })
    }

    /// Copies the file unchanged.
    pub(crate) fn copy_to(&self, copy: &mut File) -> std::io::Result<u64> {
        let mut own = &self.file;
        own.seek(SeekFrom::Start(0))?;
        std::io::copy(&mut own, copy)
    }

    /// The values of a signal in one group of rows.
    fn values(&self, group: usize, signal: &Signal) -> Result<Vec<Option<f64>>, TraceError> {
        shielded(&self.path, || self.decode(group, signal))
    }

    fn decode(&self, group: usize, signal: &Signal) -> Result<Vec<Option<f64>>, TraceError> {
        let not_parquet = |source| TraceError::NotParquet {
            path: self.path.clone(),
            source,
        };
        let column_error = || TraceError::Column {
            path: self.path.clone(),
            column: signal.name.clone(),
            expected: match signal.kind {
                ColumnType::Real => "DOUBLE",
                ColumnType::Count => "INT32",
                ColumnType::Flag => "BOOLEAN",
            },
        };
        let schema = self.reader.metadata().file_metadata().schema_descr_ptr();
        let row_count = self.rows_of(group);
        let found =
            (0..schema.num_columns()).find(|&index| schema.column(index).name() == signal.name);
        let index = found.ok_or_else(column_error)?;
        let rows = self.reader.get_row_group(group).map_err(not_parquet)?;
        let column = rows.get_column_reader(index).map_err(not_parquet)?;
        read_column(column, row_count)
            .map_err(not_parquet)?
            .filter(|values| values.len() == row_count)
            .ok_or_else(column_error)
    }

    fn rows_of(&self, group: usize) -> usize {
        let rows = self.reader.metadata().row_group(group).num_rows();
        usize::try_from(rows).unwrap_or(0)
    }
}

impl std::fmt::Debug for TraceFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TraceFile")
            .field("path", &self.path)
            .field("row_count", &self.row_count)
            .finish_non_exhaustive()
    }
}

impl Rows for TraceFile {
    type Error = TraceError;

    fn header(&self) -> &Header {
        &self.header
    }

    fn row_count(&self) -> usize {
        self.row_count
    }

    fn each_batch(&self, see: &mut dyn FnMut(&Trace)) -> Result<(), TraceError> {
        let signals = signals(&self.header);
        let mut chunk = Trace::with_capacity(self.header.clone(), 0);
        for group in 0..self.reader.num_row_groups() {
            chunk.begin_columns(self.rows_of(group));
            for signal in &signals {
                let values = self.values(group, signal)?;
                for (row, value) in values.into_iter().enumerate() {
                    signal.set(&mut chunk.row_mut(row), value);
                }
            }
            see(&chunk);
        }
        Ok(())
    }

    fn each_value(&self, signal: &str, see: &mut dyn FnMut(Option<f64>)) -> Result<(), TraceError> {
        let signals = signals(&self.header);
        if let Some(signal) = signals.iter().find(|known| known.name == signal) {
            for group in 0..self.reader.num_row_groups() {
                self.values(group, signal)?.into_iter().for_each(&mut *see);
            }
        }
        Ok(())
    }
}

/// Reads Parquet and catches panics of its reader: a malicious file can have a fitting checksum and
/// still be broken.
fn shielded<T>(path: &Path, read: impl FnOnce() -> Result<T, TraceError>) -> Result<T, TraceError> {
    // What the closures refer to is read again each time, or dropped.
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| {
        Err(TraceError::Damaged {
            path: path.to_owned(),
        })
    })
}

/// The value under a key of the file's metadata.
fn metadata<'r>(reader: &'r SerializedFileReader<File>, key: &str) -> Option<&'r str> {
    let pairs = reader.metadata().file_metadata().key_value_metadata()?;
    let pair = pairs.iter().find(|pair| pair.key == key)?;
    pair.value.as_deref()
}

fn read_header(json: &str, path: &Path) -> Result<Header, TraceError> {
    let header: Header = serde_json::from_str(json).map_err(|source| TraceError::Header {
        path: path.to_owned(),
        source,
    })?;
    let found = header.task_names.len();
    if found > MAX_TASKS {
        return Err(TraceError::TooManyTasks { found });
    }
    if header.rollers_recorded() > MOST_ROLLERS {
        // Each roller takes memory: only a malicious file has so many.
        return Err(TraceError::Damaged {
            path: path.to_owned(),
        });
    }
    Ok(header)
}

/// The number of rows that the file claims; `None` if it is impossible for a trace with this
/// header. Memory for them is reserved before they are read.
fn rows_of(reader: &SerializedFileReader<File>, header: &Header) -> Option<usize> {
    let metadata = reader.metadata();
    let mut sum = 0usize;
    for group in metadata.row_groups() {
        let rows = usize::try_from(group.num_rows()).ok()?;
        sum = sum.checked_add(rows).filter(|_| rows <= ROWS_A_GROUP)?;
    }
    let whole = usize::try_from(metadata.file_metadata().num_rows()).ok()?;
    let is_possible = sum == whole && sum <= MOST_ROWS && header.wheels.len() <= MOST_WHEELS;
    is_possible.then_some(sum)
}

/// One column as numbers; `None` if no signal has its type.
fn read_column(
    column: ColumnReader,
    row_count: usize,
) -> Result<Option<Vec<Option<f64>>>, ParquetError> {
    macro_rules! read {
        ($reader:expr, $to_f64:expr) => {{
            let mut reader = $reader;
            let (mut values, mut levels) = (Vec::new(), Vec::new());
            // A read stops at the end of each page.
            while reader
                .read_records(row_count, Some(&mut levels), None, &mut values)?
                .0
                > 0
            {}
            let mut present = values.into_iter().map($to_f64);
            if levels.is_empty() {
                present.map(Some).collect()
            } else {
                let at = |&level: &i16| if level > 0 { present.next() } else { None };
                levels.iter().map(at).collect()
            }
        }};
    }
    Ok(match column {
        ColumnReader::DoubleColumnReader(reader) => Some(read!(reader, |v: f64| v)),
        ColumnReader::Int32ColumnReader(reader) => {
            Some(read!(reader, |v: i32| f64::from(v as u32)))
        }
        ColumnReader::BoolColumnReader(reader) => {
            Some(read!(reader, |v: bool| f64::from(u8::from(v))))
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use parquet::data_type::DoubleType;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    use super::*;

    /// A page of nulls alone has rows and no values: the pages after it are read as well.
    #[test]
    fn rows_after_a_page_of_nulls_are_read() {
        let file = tempfile::tempfile().unwrap();
        let schema = parse_message_type("message m { OPTIONAL DOUBLE x; }").unwrap();
        let pages = WriterProperties::builder()
            .set_data_page_row_count_limit(2)
            .set_write_batch_size(2)
            .build();
        let (copy, schema) = (file.try_clone().unwrap(), Arc::new(schema));
        let mut writer = SerializedFileWriter::new(copy, schema, Arc::new(pages)).unwrap();
        let mut group = writer.next_row_group().unwrap();
        let mut column = group.next_column().unwrap().unwrap();
        column
            .typed::<DoubleType>()
            .write_batch(&[1.0, 2.0], Some(&[0, 0, 0, 0, 1, 1]), None)
            .unwrap();
        column.close().unwrap();
        group.close().unwrap();
        writer.close().unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let column = reader.get_row_group(0).unwrap().get_column_reader(0);
        let rows = read_column(column.unwrap(), 6).unwrap().unwrap();
        assert_eq!(rows, [None, None, None, None, Some(1.0), Some(2.0)]);
    }
}
