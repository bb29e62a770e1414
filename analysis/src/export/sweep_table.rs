//! The metrics of all runs of a sweep as one Parquet table, in folders named by the sweep's coordinates
//! (`temperature_k=300/`, the Hive convention), so that data frames and SQL engines can read it directly.

use crate::input::coordinates;
use crate::metric::{Metric, MetricScope, RunScope};
use crate::write_file::WriteError;
use parquet::basic::{Compression, ConvertedType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Maximum number of folders per table; further coordinates are columns.
const MAX_FOLDERS: usize = 1000;

/// A metric with its run.
type Row<'a> = (&'a Metric, &'a RunScope);

/// Values of one column, one per row.
enum Column {
    Text(Vec<String>),
    Whole(Vec<i64>),
    Number(Vec<f64>),
    /// A number that may be missing.
    Optional(Vec<Option<f64>>),
}

/// Writes the metrics of single runs to `folder/metrics/`, replaces earlier ones, and returns the number of rows.
///
/// # Errors
/// A file or folder that cannot be written.
pub(crate) fn write(metrics: &[Metric], folder: &Path) -> Result<usize, WriteError> {
    let table = folder.join("metrics");
    let fresh = folder.join("metrics.new");
    let rows: Vec<Row<'_>> = metrics.iter().filter_map(row).collect();
    let keys = partition_keys(&rows);
    let mut parts: BTreeMap<PathBuf, Vec<Row<'_>>> = BTreeMap::new();
    for row in &rows {
        parts.entry(folders(row.1, &keys)).or_default().push(*row);
    }
    remove(&fresh)?;
    for (part, rows) in &parts {
        let folder = fresh.join(part);
        fs::create_dir_all(&folder).map_err(|error| WriteError::new(&folder, error))?;
        let path = folder.join("metrics.parquet");
        write_part(&path, &columns(rows, &keys)).map_err(|error| WriteError::new(&path, error))?;
    }
    // Otherwise, parts of an earlier sweep would be read together with this one.
    remove(&table)?;
    if !parts.is_empty() {
        fs::rename(&fresh, &table).map_err(|error| WriteError::new(&table, error))?;
    }
    Ok(rows.len())
}

fn row(metric: &Metric) -> Option<Row<'_>> {
    match &metric.scope {
        MetricScope::Run(place) => Some((metric, place)),
        MetricScope::Sweep(_) => None,
    }
}

fn remove(folder: &Path) -> Result<(), WriteError> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(WriteError::new(folder, error))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}

/// The leading axes that become folders.
fn partition_keys(rows: &[Row<'_>]) -> Vec<String> {
    let all = all_keys(rows);
    let count = |keys: &[String]| {
        let folders: BTreeSet<PathBuf> = rows.iter().map(|row| folders(row.1, keys)).collect();
        folders.len()
    };
    let fitting = (0..=all.len()).rev().find(|&length| count(&all[..length]) <= MAX_FOLDERS);
    all[..fitting.unwrap_or(0)].to_vec()
}

/// The swept keys in the order of the sweep.
fn all_keys(rows: &[Row<'_>]) -> Vec<String> {
    let mut keys: Vec<String> = Vec::new();
    for coordinate in rows.iter().flat_map(|(_, run)| &run.coordinates) {
        if !keys.contains(&coordinate.key) {
            keys.push(coordinate.key.clone());
        }
    }
    keys
}

fn folders(run: &RunScope, keys: &[String]) -> PathBuf {
    let places = run.coordinates.iter().filter(|coordinate| keys.contains(&coordinate.key));
    places
        .map(|coordinate| {
            format!("{}={}", column_name(&coordinate.key), escaped(&coordinate.value))
        })
        .collect()
}

/// The last part of a key, as in the names of recordings.
fn column_name(key: &str) -> &str {
    coordinates::last_part(key)
}

/// Escapes characters that a folder name cannot contain, as Hive and URLs do: `%` and two hexadecimal digits per byte.
fn escaped(value: &str) -> String {
    let mut text = String::with_capacity(value.len());
    for byte in value.bytes() {
        if byte.is_ascii_alphanumeric() || b"._-+".contains(&byte) {
            text.push(char::from(byte));
        } else {
            text.push_str(&format!("%{byte:02X}"));
        }
    }
    text
}

/// The columns of rows; coordinates that are not folders come first.
fn columns<'a>(rows: &[Row<'a>], folders: &[String]) -> Vec<(String, Column)> {
    let text = |of: fn(&'a Metric, &'a RunScope) -> &'a str| {
        Column::Text(rows.iter().map(|(metric, run)| of(metric, run).to_owned()).collect())
    };
    let mut columns = Vec::new();
    for key in all_keys(rows).into_iter().filter(|key| !folders.contains(key)) {
        let value = |(_, run): &Row<'a>| {
            let coordinate = run.coordinates.iter().find(|coordinate| coordinate.key == key);
            coordinate.map(|coordinate| coordinate.value.clone()).unwrap_or_default()
        };
        let values: Vec<String> = rows.iter().map(value).collect();
        let numbers: Result<Vec<f64>, _> = values.iter().map(|value| value.parse()).collect();
        let column = numbers.map_or(Column::Text(values), Column::Number);
        columns.push((column_name(&key).to_owned(), column));
    }
    let replicates = rows.iter().map(|(_, run)| i64::from(run.replicate)).collect();
    let more = [
        ("replicate", Column::Whole(replicates)),
        ("metric", text(|metric, _| metric.name())),
        ("value", Column::Number(rows.iter().map(|(metric, _)| metric.value).collect())),
        (
            "standard_error",
            Column::Optional(rows.iter().map(|(metric, _)| metric.standard_error).collect()),
        ),
        ("theory", Column::Optional(rows.iter().map(|(metric, _)| metric.theory).collect())),
        ("unit", text(|metric, _| metric.unit())),
        ("outcome", text(|_, run| &run.outcome)),
        ("file", text(|_, run| &run.file)),
    ];
    columns.extend(more.map(|(name, column)| (name.to_owned(), column)));
    columns
}

impl Column {
    fn schema(&self, name: &str) -> Result<Arc<Type>, ParquetError> {
        let (physical, repetition) = match self {
            Self::Text(_) => (Physical::BYTE_ARRAY, Repetition::REQUIRED),
            Self::Whole(_) => (Physical::INT64, Repetition::REQUIRED),
            Self::Number(_) => (Physical::DOUBLE, Repetition::REQUIRED),
            Self::Optional(_) => (Physical::DOUBLE, Repetition::OPTIONAL),
        };
        let column = Type::primitive_type_builder(name, physical).with_repetition(repetition);
        let column = match self {
            Self::Text(_) => column.with_converted_type(ConvertedType::UTF8),
            Self::Whole(_) | Self::Number(_) | Self::Optional(_) => column,
        };
        column.build().map(Arc::new)
    }

    fn write(&self, writer: &mut ColumnWriter<'_>) -> Result<(), ParquetError> {
        match (self, writer) {
            (Self::Text(values), ColumnWriter::ByteArrayColumnWriter(writer)) => {
                let values: Vec<ByteArray> =
                    values.iter().map(|value| value.as_str().into()).collect();
                writer.write_batch(&values, None, None)?;
            }
            (Self::Whole(values), ColumnWriter::Int64ColumnWriter(writer)) => {
                writer.write_batch(values, None, None)?;
            }
            (Self::Number(values), ColumnWriter::DoubleColumnWriter(writer)) => {
                writer.write_batch(values, None, None)?;
            }
            (Self::Optional(values), ColumnWriter::DoubleColumnWriter(writer)) => {
                let levels: Vec<i16> =
                    values.iter().map(|value| i16::from(value.is_some())).collect();
                let values: Vec<f64> = values.iter().copied().flatten().collect();
                writer.write_batch(&values, Some(&levels), None)?;
            }
            _ => return Err(ParquetError::General("a column of another type".to_owned())),
        }
        Ok(())
    }
}

fn write_part(path: &Path, columns: &[(String, Column)]) -> Result<(), ParquetError> {
    let fields: Result<Vec<Arc<Type>>, ParquetError> =
        columns.iter().map(|(name, column)| column.schema(name)).collect();
    let schema = Type::group_type_builder("metrics").with_fields(fields?).build()?;
    let zstd = Compression::ZSTD(ZstdLevel::try_new(1)?);
    let properties = WriterProperties::builder().set_compression(zstd).build();
    let mut writer =
        SerializedFileWriter::new(File::create(path)?, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (_, column) in columns {
        if let Some(mut next) = group.next_column()? {
            column.write(next.untyped())?;
            next.close()?;
        }
    }
    group.close()?;
    writer.close().map(drop)
}
