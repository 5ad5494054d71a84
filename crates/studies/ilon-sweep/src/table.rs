//! `runs.parquet`: one row per run.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use ilon_sim::Error;
use ilon_trace::TraceError;
use ilon_trace::file::{write_atomically, write_text};
use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde::Serialize;

use crate::axis::{number_of, text_of};
use crate::row::{Row, figure_names};
use crate::study::Study;

/// Rows per group of the file.
const ROWS_A_GROUP: usize = 16_384;

/// The key of the study's fingerprint among the file's key-value metadata.
const STUDY_KEY: &str = "ilon.study";

/// The values of one column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Integers, one in each row.
    Whole(Vec<i64>),
    /// Texts.
    Text(Vec<Option<String>>),
    /// Numbers.
    Number(Vec<Option<f64>>),
}

/// Writes the rows of a study, atomically; the same rows give the same bytes.
///
/// # Errors
/// [`TraceError::Io`], [`TraceError::Encode`].
pub fn write_runs(path: &Path, study: &Study, rows: &[Row]) -> Result<(), TraceError> {
    let encode = |source| TraceError::Encode {
        path: path.to_owned(),
        source,
    };
    write_atomically(path, |file| {
        let file = file.try_clone().map_err(|source| TraceError::Io {
            doing: "write",
            path: path.to_owned(),
            source,
        })?;
        write(file, study, rows).map_err(encode)
    })
}

/// Writes a value as JSON, which an error calls `what`.
pub(crate) fn write_json(
    path: &Path,
    what: &'static str,
    value: &impl Serialize,
) -> Result<(), Error> {
    let json = serde_json::to_string_pretty(value);
    let json = json.map_err(|error| Error::encode(what, &error))?;
    Ok(write_text(path, &(json + "\n"))?)
}

/// Returns the columns of `runs.parquet`: their names and values. Names and types depend only on
/// the study.
pub fn columns(study: &Study, rows: &[Row]) -> Vec<(String, Cells)> {
    let whole = |of: fn(&Row) -> u64| Cells::Whole(rows.iter().map(|row| of(row) as i64).collect());
    let text = |of: &dyn Fn(&Row) -> Option<String>| Cells::Text(rows.iter().map(of).collect());
    let number = |of: &dyn Fn(&Row) -> Option<f64>| Cells::Number(rows.iter().map(of).collect());
    let mut columns = vec![
        ("run", whole(|row| row.run)),
        ("key", text(&|row| Some(row.key.clone()))),
        ("status", text(&|row| Some(row.status.word().to_owned()))),
        ("error", text(&|row| row.error.clone())),
        ("scenario", text(&|row| Some(row.scenario.clone()))),
        ("point", whole(|row| row.point)),
        ("repetition", whole(|row| u64::from(row.repetition))),
    ];
    for (index, varied) in study.columns().iter().enumerate() {
        let value = |row: &Row| row.values.get(index).cloned();
        let cells = if varied.is_numeric {
            number(&|row| value(row).as_ref().and_then(number_of))
        } else {
            text(&|row| value(row).as_ref().map(text_of))
        };
        columns.push((&varied.key, cells));
    }
    columns.push(("trace_hash", text(&|row| row.trace_hash.clone())));
    for (index, name) in figure_names().iter().enumerate() {
        columns.push((name, number(&|row| row.figure(index))));
    }
    let named = |(name, cells): (&str, Cells)| (name.to_owned(), cells);
    columns.into_iter().map(named).collect()
}

fn write(file: File, study: &Study, rows: &[Row]) -> Result<(), ParquetError> {
    let fields = columns(study, &[]);
    let fields = fields
        .iter()
        .map(|(name, cells)| field(name, cells).map(Arc::new));
    let schema = Type::group_type_builder("runs")
        .with_fields(fields.collect::<Result<Vec<_>, _>>()?)
        .build()?;
    let about = serde_json::json!({
        "name": study.name(),
        "fingerprint": study.fingerprint(),
        "ilon": env!("CARGO_PKG_VERSION"),
    });
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(vec![KeyValue::new(
            STUDY_KEY.to_owned(),
            about.to_string(),
        )]))
        .build();
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
    for rows in rows.chunks(ROWS_A_GROUP) {
        let mut group = writer.next_row_group()?;
        for (name, cells) in columns(study, rows) {
            let Some(mut out) = group.next_column()? else {
                return Err(ParquetError::General(format!("the schema lacks `{name}`")));
            };
            match cells {
                Cells::Whole(values) => {
                    out.typed::<Int64Type>().write_batch(&values, None, None)?;
                }
                Cells::Text(values) => {
                    let (values, levels) = present(values);
                    let values: Vec<ByteArray> = values
                        .iter()
                        .map(|text| ByteArray::from(text.as_str()))
                        .collect();
                    out.typed::<ByteArrayType>()
                        .write_batch(&values, Some(&levels), None)?;
                }
                Cells::Number(values) => {
                    let (values, levels) = present(values);
                    out.typed::<DoubleType>()
                        .write_batch(&values, Some(&levels), None)?;
                }
            }
            out.close()?;
        }
        group.close()?;
    }
    writer.close()?;
    Ok(())
}

/// Returns the present values, and for each row 1 if it has one and 0 if not.
fn present<T>(all: Vec<Option<T>>) -> (Vec<T>, Vec<i16>) {
    let levels = all.iter().map(|value| i16::from(value.is_some())).collect();
    (all.into_iter().flatten().collect(), levels)
}

fn field(name: &str, cells: &Cells) -> Result<Type, ParquetError> {
    let (physical, logical, repetition) = match cells {
        Cells::Whole(_) => (PhysicalType::INT64, None, Repetition::REQUIRED),
        Cells::Text(_) => (
            PhysicalType::BYTE_ARRAY,
            Some(LogicalType::String),
            Repetition::OPTIONAL,
        ),
        Cells::Number(_) => (PhysicalType::DOUBLE, None, Repetition::OPTIONAL),
    };
    Type::primitive_type_builder(name, physical)
        .with_repetition(repetition)
        .with_logical_type(logical)
        .build()
}
