//! The trace as a Parquet file: one row a control step, columns named with their units, the header as JSON under
//! [`HEADER_KEY`] in the file's key-value metadata. pandas, polars and DuckDB read it as it is.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as PhysicalType};
use parquet::column::reader::ColumnReader;
use parquet::data_type::{BoolType, DoubleType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{ColumnPath, Type};

use crate::columns::{Kind, Signal, signals};
use crate::error::TraceError;
use crate::record::{MAX_TASKS, Record, WheelSample};
use crate::trace::{Header, Trace};

/// The key of the header among the file's key-value metadata.
pub const HEADER_KEY: &str = "ilon.trace.header";

impl Trace {
    /// Writes the trace as a Parquet file. The file appears whole or not at all.
    ///
    /// # Errors
    /// [`TraceError::Io`] where the file cannot be written, [`TraceError::TooManyTasks`].
    pub fn write_parquet(&self, path: &Path) -> Result<(), TraceError> {
        let found = self.header.task_names.len();
        if found > MAX_TASKS {
            return Err(TraceError::TooManyTasks { found });
        }
        write_atomically(path, |file| {
            write_rows(self, file).map_err(|source| TraceError::Encode {
                path: path.to_owned(),
                source,
            })
        })
    }

    /// Reads a trace back from its file, bit for bit, or from a folder of [`crate::parts`].
    ///
    /// # Errors
    /// Says which file is missing, broken, or no trace, and which column it lacks.
    pub fn read_parquet(path: &Path) -> Result<Self, TraceError> {
        if path.is_dir() {
            return crate::parts::read(path);
        }
        let file = File::open(path).map_err(|source| TraceError::Io {
            doing: "read",
            path: path.to_owned(),
            source,
        })?;
        let not_parquet = |source| TraceError::NotParquet {
            path: path.to_owned(),
            source,
        };
        let reader = SerializedFileReader::new(file).map_err(not_parquet)?;
        let header = read_header(&reader, path)?;
        let mut trace = Self::with_capacity(header, 0);
        for group in 0..reader.num_row_groups() {
            append_row_group(&mut trace, &reader, group, path)?;
        }
        Ok(trace)
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
    let io_error = |doing, path: &Path, source| TraceError::Io {
        doing,
        path: path.to_owned(),
        source,
    };
    let partial = partial_path(path);
    let mut file = File::create(&partial).map_err(|e| io_error("create", path, e))?;
    let written = write(&mut file)
        .and_then(|()| file.flush().map_err(|e| io_error("write", path, e)))
        .and_then(|()| fs::rename(&partial, path).map_err(|e| io_error("write", path, e)));
    if written.is_err() {
        // The first error is the one to tell; a partial file that cannot be removed either adds nothing to it.
        let _ = fs::remove_file(&partial);
    }
    written
}

/// Writes text to a file so that nobody ever sees half of it.
///
/// # Errors
/// [`TraceError::Io`]; `path` is then as it was.
pub fn write_text(path: &Path, text: &str) -> Result<(), TraceError> {
    write_atomically(path, |file| {
        file.write_all(text.as_bytes())
            .map_err(|source: io::Error| TraceError::Io {
                doing: "write",
                path: path.to_owned(),
                source,
            })
    })
}

/// A hidden neighbour of `path`, of this process alone.
fn partial_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.partial", std::process::id()))
}

/// Writes header and rows, all steps in one row group.
fn write_rows(trace: &Trace, file: &mut File) -> Result<(), ParquetError> {
    let signals = signals(&trace.header);
    let fields = signals
        .iter()
        .map(|signal| column_type(signal).map(Arc::new))
        .collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("trace")
        .with_fields(fields)
        .build()?;
    let header_json =
        serde_json::to_string(&trace.header).map_err(|e| ParquetError::External(Box::new(e)))?;
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(vec![KeyValue::new(
            HEADER_KEY.to_owned(),
            header_json,
        )]));
    for signal in signals.iter().filter(|s| s.kind == Kind::Real) {
        // Neighbouring values share sign, exponent and leading digits: split by byte they compress.
        let column = ColumnPath::from(signal.name.as_str());
        properties = properties
            .set_column_dictionary_enabled(column.clone(), false)
            .set_column_encoding(column, Encoding::BYTE_STREAM_SPLIT);
    }
    let mut writer =
        SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties.build()))?;
    let mut rows = writer.next_row_group()?;
    for signal in &signals {
        write_column(&mut rows, signal, trace)?;
    }
    rows.close()?;
    writer.close()?;
    Ok(())
}

/// The Parquet type of a signal.
fn column_type(signal: &Signal) -> Result<Type, ParquetError> {
    let (physical, logical) = match signal.kind {
        Kind::Real => (PhysicalType::DOUBLE, None),
        Kind::Count => (PhysicalType::INT32, Some(LogicalType::integer(32, false))),
        Kind::Flag => (PhysicalType::BOOLEAN, None),
    };
    let repetition = if signal.nullable {
        Repetition::OPTIONAL
    } else {
        Repetition::REQUIRED
    };
    Type::primitive_type_builder(&signal.name, physical)
        .with_repetition(repetition)
        .with_logical_type(logical)
        .build()
}

/// Writes one signal over all steps.
fn write_column<W: Write + Send>(
    rows: &mut SerializedRowGroupWriter<'_, W>,
    signal: &Signal,
    trace: &Trace,
) -> Result<(), ParquetError> {
    let Some(mut column) = rows.next_column()? else {
        return Err(ParquetError::General(format!(
            "the schema lacks the column `{}`",
            signal.name
        )));
    };
    let steps = 0..trace.records().len();
    let values: Vec<Option<f64>> = steps.map(|step| signal.get(trace, step)).collect();
    // Definition levels: 1 where a value is present, 0 where it is null; required columns have none.
    let levels: Vec<i16> = values.iter().map(|v| i16::from(v.is_some())).collect();
    let levels = signal.nullable.then_some(levels.as_slice());
    let present = values.iter().flatten();
    match signal.kind {
        Kind::Real => {
            let values: Vec<f64> = present.copied().collect();
            column
                .typed::<DoubleType>()
                .write_batch(&values, levels, None)?;
        }
        Kind::Count => {
            let values: Vec<i32> = present.map(|&v| v as u32 as i32).collect();
            column
                .typed::<Int32Type>()
                .write_batch(&values, levels, None)?;
        }
        Kind::Flag => {
            let values: Vec<bool> = present.map(|&v| v != 0.0).collect();
            column
                .typed::<BoolType>()
                .write_batch(&values, levels, None)?;
        }
    }
    column.close()
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

/// Appends the steps of one row group.
fn append_row_group(
    trace: &mut Trace,
    reader: &SerializedFileReader<File>,
    group: usize,
    path: &Path,
) -> Result<(), TraceError> {
    let not_parquet = |source| TraceError::NotParquet {
        path: path.to_owned(),
        source,
    };
    let rows = reader.get_row_group(group).map_err(not_parquet)?;
    let row_count = usize::try_from(rows.metadata().num_rows()).unwrap_or(0);
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let mut records = vec![Record::default(); row_count];
    let mut wheels = vec![vec![WheelSample::default(); trace.wheel_count()]; row_count];
    for signal in signals(&trace.header) {
        let column_error = || TraceError::Column {
            path: path.to_owned(),
            column: signal.name.clone(),
            expected: match signal.kind {
                Kind::Real => "DOUBLE",
                Kind::Count => "INT32",
                Kind::Flag => "BOOLEAN",
            },
        };
        let index = (0..schema.num_columns())
            .find(|&index| schema.column(index).name() == signal.name)
            .ok_or_else(column_error)?;
        let column = rows.get_column_reader(index).map_err(not_parquet)?;
        let values = read_column(column, row_count)
            .map_err(not_parquet)?
            .filter(|values| values.len() == row_count)
            .ok_or_else(column_error)?;
        for (step, value) in values.into_iter().enumerate() {
            signal.set(&mut records[step], &mut wheels[step], value);
        }
    }
    for (record, wheels) in records.into_iter().zip(&wheels) {
        trace.push(record, wheels);
    }
    Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::made_up_trace;

    /// A folder of its own for one test, gone at the end.
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

    #[rstest::rstest]
    #[case::closed_loop(true)]
    #[case::open_loop(false)]
    fn a_trace_comes_back_from_its_file_bit_for_bit(#[case] closed_loop: bool) {
        let folder = Folder::new(if closed_loop { "closed" } else { "open" });
        let path = folder.0.join("trace.parquet");
        // More steps than one page of the file holds.
        let trace = made_up_trace(3, 30_000, closed_loop);
        trace.write_parquet(&path).unwrap();
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

        made_up_trace(3, 200, true).write_parquet(&path).unwrap();
        let whole = fs::read(&path).unwrap();
        fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        let cut = Trace::read_parquet(&path).unwrap_err().to_string();
        assert!(
            cut.starts_with(&format!("`{shown}` cannot be read as Parquet")),
            "{cut}"
        );
    }

    #[test]
    fn a_trace_that_cannot_be_written_leaves_nothing_behind() {
        let folder = Folder::new("unwritable");
        // A folder stands where the file should go.
        let path = folder.0.join("trace.parquet");
        fs::create_dir(&path).unwrap();
        let error = made_up_trace(3, 2, true).write_parquet(&path).unwrap_err();
        let expected = format!("cannot write `{}`: ", path.display());
        assert!(error.to_string().starts_with(&expected), "{error}");
        assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 1);
    }
}
