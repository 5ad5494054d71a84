//! Writing traces.

use std::fs::File;
use std::io::{Seek, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, DoubleType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{ColumnPath, Type};

use super::atomic::{Unfinished, io_error};
use super::checksum::{self, Summed};
use super::format::HEADER_KEY;
use crate::columns::{ColumnType, Signal, signals};
use crate::error::TraceError;
use crate::header::Header;
use crate::record::MAX_TASKS;
use crate::trace::Trace;

/// A trace file that grows by groups of rows and gets its name when it is complete.
#[derive(Debug)]
pub struct TraceWriter<W: Write + Send = File> {
    signals: Vec<Signal>,
    writer: SerializedFileWriter<Summed<W>>,
    place: Destination,
}

/// Where a trace file grows.
#[derive(Debug)]
enum Destination {
    /// Under a temporary name until it is finished.
    Named(Unfinished),
    /// Without a name, on the disk of this folder.
    Nameless(PathBuf),
}

impl TraceWriter {
    /// Begins the file `path`, which grows in the folder `growing_in` on the same file system.
    ///
    /// # Errors
    /// [`TraceError::Io`] if the file cannot be created, [`TraceError::TooManyTasks`].
    pub fn begin(path: &Path, growing_in: &Path, header: &Header) -> Result<Self, TraceError> {
        let unfinished = Unfinished::create(path, growing_in)?;
        let file = unfinished.file()?;
        Self::into(Destination::Named(unfinished), file, header)
    }

    /// Begins a file without a name, which vanishes when its last handle is closed.
    pub(crate) fn begin_nameless(file: File, header: &Header) -> Result<Self, TraceError> {
        Self::into(Destination::Nameless(std::env::temp_dir()), file, header)
    }

    /// Ends the file with the header and gives it its name. The header must have the same signals
    /// as the one at the beginning.
    ///
    /// # Errors
    /// [`TraceError::Encode`], [`TraceError::Io`].
    pub fn finish(self, header: &Header) -> Result<(), TraceError> {
        self.end(header).map(|_| ())
    }
}

impl<W: Write + Seek + Send> TraceWriter<W> {
    /// Begins a file that never gets a name, such as one in memory.
    pub(super) fn begin_into(file: W, header: &Header) -> Result<Self, TraceError> {
        Self::into(Destination::Nameless(PathBuf::from("memory")), file, header)
    }

    fn into(place: Destination, file: W, header: &Header) -> Result<Self, TraceError> {
        let found = header.task_names.len();
        if found > MAX_TASKS {
            return Err(TraceError::TooManyTasks { found });
        }
        let signals = signals(header);
        let writer = writer(file, &signals).map_err(|source| encode(place.path(), source))?;
        Ok(Self {
            signals,
            writer,
            place,
        })
    }

    /// Adds rows of a trace as one group.
    ///
    /// # Errors
    /// [`TraceError::Encode`].
    pub fn write_group(&mut self, trace: &Trace, rows: Range<usize>) -> Result<(), TraceError> {
        let mut write = || -> Result<(), ParquetError> {
            let mut group = self.writer.next_row_group()?;
            for signal in &self.signals {
                let values: Vec<Option<f64>> =
                    rows.clone().map(|row| signal.get(trace, row)).collect();
                write_column(&mut group, signal, &values)?;
            }
            group.close()?;
            Ok(())
        };
        write().map_err(|source| encode(self.place.path(), source))
    }

    /// Ends the file with the header, gives it its name if it is to have one, and returns it. Data
    /// known only after the run, such as the header's twins, is included, because Parquet's
    /// metadata comes last.
    pub(crate) fn end(mut self, header: &Header) -> Result<W, TraceError> {
        let json = serde_json::to_string(header).map_err(|source| {
            encode(self.place.path(), ParquetError::External(Box::new(source)))
        })?;
        let header = KeyValue::new(HEADER_KEY.to_owned(), json);
        self.writer.append_key_value_metadata(header);
        let file = self.writer.into_inner();
        let file = file.map_err(|source| encode(self.place.path(), source))?;
        let file = file
            .finish()
            .map_err(io_error("write", self.place.path()))?;
        if let Destination::Named(unfinished) = self.place {
            unfinished.finish()?;
        }
        Ok(file)
    }
}

impl Destination {
    fn path(&self) -> &Path {
        match self {
            Self::Named(unfinished) => unfinished.path(),
            Self::Nameless(folder) => folder,
        }
    }
}

fn encode(path: &Path, source: ParquetError) -> TraceError {
    let source = match source {
        ParquetError::External(error) => match error.downcast::<std::io::Error>() {
            Ok(error) => return io_error("write", path)(*error),
            Err(error) => ParquetError::External(error),
        },
        source => source,
    };
    TraceError::Encode {
        path: path.to_owned(),
        source,
    }
}

/// A Parquet writer with the columns of these signals.
fn writer<W: Write + Seek + Send>(
    file: W,
    signals: &[Signal],
) -> Result<SerializedFileWriter<Summed<W>>, ParquetError> {
    let fields = signals
        .iter()
        .map(|signal| column_type(signal).map(Arc::new))
        .collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("trace")
        .with_fields(fields)
        .build()?;
    let mut properties = WriterProperties::builder().set_compression(Compression::SNAPPY);
    for signal in signals.iter().filter(|s| s.kind == ColumnType::Real) {
        // Neighbouring values share sign, exponent and leading digits: split by byte they compress.
        let column = ColumnPath::from(signal.name.as_str());
        properties = properties
            .set_column_dictionary_enabled(column.clone(), false)
            .set_column_encoding(column, Encoding::BYTE_STREAM_SPLIT);
    }
    let properties = Arc::new(properties.build());
    let mut writer = SerializedFileWriter::new(Summed::new(file), Arc::new(schema), properties)?;
    writer.write_all(&checksum::empty())?;
    Ok(writer)
}

/// The Parquet type of a signal.
fn column_type(signal: &Signal) -> Result<Type, ParquetError> {
    let (physical, logical) = match signal.kind {
        ColumnType::Real => (PhysicalType::DOUBLE, None),
        ColumnType::Count => (PhysicalType::INT32, Some(LogicalType::integer(32, false))),
        ColumnType::Flag => (PhysicalType::BOOLEAN, None),
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

/// Writes one signal over some rows.
fn write_column<W: Write + Send>(
    rows: &mut SerializedRowGroupWriter<'_, W>,
    signal: &Signal,
    values: &[Option<f64>],
) -> Result<(), ParquetError> {
    let Some(mut column) = rows.next_column()? else {
        return Err(ParquetError::General(format!(
            "the schema lacks the column `{}`",
            signal.name
        )));
    };
    // Definition levels: 1 where a value is present, 0 where it is null; required columns have
    // none.
    let levels: Vec<i16> = values.iter().map(|v| i16::from(v.is_some())).collect();
    let levels = signal.nullable.then_some(levels.as_slice());
    let present = values.iter().flatten();
    match signal.kind {
        ColumnType::Real => {
            let values: Vec<f64> = present.copied().collect();
            column
                .typed::<DoubleType>()
                .write_batch(&values, levels, None)?;
        }
        ColumnType::Count => {
            let values: Vec<i32> = present.map(|&v| v as u32 as i32).collect();
            column
                .typed::<Int32Type>()
                .write_batch(&values, levels, None)?;
        }
        ColumnType::Flag => {
            let values: Vec<bool> = present.map(|&v| v != 0.0).collect();
            column
                .typed::<BoolType>()
                .write_batch(&values, levels, None)?;
        }
    }
    column.close()
}
