//! `runs.parquet`: one row a run.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use ilon_trace::TraceError;
use ilon_trace::file::write_atomically;
use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use toml::Value;

use super::axis::number_of;
use super::row::{Row, figure_names};
use super::study::Study;

/// Rows that stand together in the file.
const ROWS_A_GROUP: usize = 16_384;

/// The key of the study's fingerprint among the file's key-value metadata.
const STUDY_KEY: &str = "ilon.study";

/// A column of the file, and where its values come from.
struct Column {
    name: String,
    of: Of,
}

/// What a row has in a column, if it has anything there.
type Get<T> = Box<dyn Fn(&Row) -> Option<T>>;

enum Of {
    Whole(fn(&Row) -> u64),
    Text(Get<String>),
    Number(Get<f64>),
}

/// Writes the rows of a study. The file appears whole or not at all, and the same rows make the same bytes.
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

fn columns(study: &Study) -> Vec<Column> {
    let column = |name: &str, of: Of| Column {
        name: name.to_owned(),
        of,
    };
    let mut columns = vec![
        column("run", Of::Whole(|row| row.run)),
        column("key", Of::Text(Box::new(|row| Some(row.key.clone())))),
        column(
            "status",
            Of::Text(Box::new(|row| Some(row.status.word().to_owned()))),
        ),
        column("error", Of::Text(Box::new(|row| row.error.clone()))),
        column(
            "scenario",
            Of::Text(Box::new(|row| Some(row.scenario.clone()))),
        ),
        column("point", Of::Whole(|row| row.point)),
        column("repetition", Of::Whole(|row| u64::from(row.repetition))),
    ];
    for (index, varied) in study.columns().iter().enumerate() {
        let of = if varied.is_numeric {
            Of::Number(Box::new(move |row| {
                row.values.get(index).and_then(number_of)
            }))
        } else {
            Of::Text(Box::new(move |row| row.values.get(index).map(text_of)))
        };
        columns.push(column(&varied.key, of));
    }
    columns.push(column(
        "trace_hash",
        Of::Text(Box::new(|row| row.trace_hash.clone())),
    ));
    for (index, name) in figure_names().iter().enumerate() {
        columns.push(column(
            name,
            Of::Number(Box::new(move |row| row.figure(index))),
        ));
    }
    columns
}

/// A value as a text: one that is a text by itself, all others as TOML.
pub fn text_of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn write(file: File, study: &Study, rows: &[Row]) -> Result<(), ParquetError> {
    let columns = columns(study);
    let fields = columns.iter().map(|column| field(column).map(Arc::new));
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
        for column in &columns {
            let Some(mut out) = group.next_column()? else {
                return Err(ParquetError::General(format!(
                    "the schema lacks `{}`",
                    column.name
                )));
            };
            match &column.of {
                Of::Whole(of) => {
                    let values: Vec<i64> = rows.iter().map(|row| of(row) as i64).collect();
                    out.typed::<Int64Type>().write_batch(&values, None, None)?;
                }
                Of::Text(of) => {
                    let (values, levels) = present(rows, of);
                    let values: Vec<ByteArray> = values
                        .iter()
                        .map(|text| ByteArray::from(text.as_str()))
                        .collect();
                    out.typed::<ByteArrayType>()
                        .write_batch(&values, Some(&levels), None)?;
                }
                Of::Number(of) => {
                    let (values, levels) = present(rows, of);
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

/// The values that are there, and for each row 1 where it has one and 0 where not.
fn present<T>(rows: &[Row], of: impl Fn(&Row) -> Option<T>) -> (Vec<T>, Vec<i16>) {
    let all: Vec<Option<T>> = rows.iter().map(of).collect();
    let levels = all.iter().map(|value| i16::from(value.is_some())).collect();
    (all.into_iter().flatten().collect(), levels)
}

fn field(column: &Column) -> Result<Type, ParquetError> {
    let (physical, logical, repetition) = match column.of {
        Of::Whole(_) => (PhysicalType::INT64, None, Repetition::REQUIRED),
        Of::Text(_) => (
            PhysicalType::BYTE_ARRAY,
            Some(LogicalType::String),
            Repetition::OPTIONAL,
        ),
        Of::Number(_) => (PhysicalType::DOUBLE, None, Repetition::OPTIONAL),
    };
    Type::primitive_type_builder(&column.name, physical)
        .with_repetition(repetition)
        .with_logical_type(logical)
        .build()
}
