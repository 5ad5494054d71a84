//! Reading traces.

use std::fs::File;
use std::path::{Path, PathBuf};

use parquet::column::reader::ColumnReader;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use tempfile::TempDir;

use super::HEADER_KEY;
use crate::columns::{Kind, Signal, signals};
use crate::error::TraceError;
use crate::record::MAX_TASKS;
use crate::rows::{Rows, Which};
use crate::trace::{Header, Trace};

/// A trace in its file: its rows are read as they are gone through, a group at a time, so that memory does not grow with
/// the length of the run.
pub struct TraceFile {
    path: PathBuf,
    reader: SerializedFileReader<File>,
    header: Header,
    row_count: usize,
    /// The folder that goes with the file, where it is temporary.
    folder: Option<TempDir>,
}

impl TraceFile {
    /// Opens a trace and reads its header.
    ///
    /// # Errors
    /// Says whether the file is missing, broken, or no trace.
    pub fn open(path: &Path) -> Result<Self, TraceError> {
        let file = File::open(path).map_err(|source| TraceError::Io {
            doing: "read",
            path: path.to_owned(),
            source,
        })?;
        let reader = SerializedFileReader::new(file).map_err(|source| TraceError::NotParquet {
            path: path.to_owned(),
            source,
        })?;
        let header = read_header(&reader, path)?;
        let row_count = reader.metadata().file_metadata().num_rows();
        Ok(Self {
            path: path.to_owned(),
            reader,
            header,
            row_count: usize::try_from(row_count).unwrap_or(0),
            folder: None,
        })
    }

    /// Takes the folder in which the file stands: it is removed with this.
    pub(crate) fn with_folder(self, folder: Option<TempDir>) -> Self {
        Self { folder, ..self }
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The values of a signal in one group of rows.
    fn values(&self, group: usize, signal: &Signal) -> Result<Vec<Option<f64>>, TraceError> {
        let not_parquet = |source| TraceError::NotParquet {
            path: self.path.clone(),
            source,
        };
        let column_error = || TraceError::Column {
            path: self.path.clone(),
            column: signal.name.clone(),
            expected: match signal.kind {
                Kind::Real => "DOUBLE",
                Kind::Count => "INT32",
                Kind::Flag => "BOOLEAN",
            },
        };
        let schema = self.reader.metadata().file_metadata().schema_descr_ptr();
        let index = (0..schema.num_columns())
            .find(|&index| schema.column(index).name() == signal.name)
            .ok_or_else(column_error)?;
        let rows = self.reader.get_row_group(group).map_err(not_parquet)?;
        let row_count = self.rows_of(group);
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
            .field("folder", &self.folder)
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

    fn each_chunk(&self, which: Which, see: &mut dyn FnMut(&Trace)) -> Result<(), TraceError> {
        let mut signals = signals(&self.header);
        signals.retain(|signal| signal.is_among(which));
        let mut chunk = Trace::with_capacity(self.header.clone(), 0);
        for group in 0..self.reader.num_row_groups() {
            chunk.begin_columns(self.rows_of(group));
            for signal in &signals {
                let values = self.values(group, signal)?;
                for (row, value) in values.into_iter().enumerate() {
                    let (record, wheels) = chunk.row_mut(row);
                    signal.set(record, wheels, value);
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

/// The header from the file's metadata.
fn read_header(reader: &SerializedFileReader<File>, path: &Path) -> Result<Header, TraceError> {
    let metadata = reader.metadata().file_metadata().key_value_metadata();
    let json = metadata
        .into_iter()
        .flatten()
        .find(|pair| pair.key == HEADER_KEY)
        .and_then(|pair| pair.value.as_deref())
        .ok_or_else(|| TraceError::NotATrace {
            path: path.to_owned(),
        })?;
    let header: Header = serde_json::from_str(json).map_err(|source| TraceError::Header {
        path: path.to_owned(),
        source,
    })?;
    let found = header.task_names.len();
    if found > MAX_TASKS {
        return Err(TraceError::TooManyTasks { found });
    }
    Ok(header)
}

/// One column as numbers; `None` where it is of a type that no signal has.
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
