//! The metrics of all runs of a sweep as one Parquet table, in folders named by the sweep's coordinates
//! (`temperature_k=300/`, the Hive convention), so that data frames and SQL engines can read it directly.

use crate::input::coordinates;
use crate::metric::{Metric, MetricScope, RunScope};
use crate::metric_files::table::MetricTable;
use crate::table::parquet::ParquetTable;
use crate::write_file::WriteError;
use kinetoscope_files::atomic_file::NewFile;
use parquet::errors::ParquetError;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Maximum number of folders per table; further coordinates are columns.
const MAX_FOLDERS: usize = 1000;

/// A metric with its run.
type Row<'a> = (&'a Metric, &'a RunScope);

/// Writes the metrics of single runs to `folder/metrics/`, replaces earlier ones, and returns the number of rows.
///
/// # Errors
/// A file or folder that cannot be written.
pub(crate) fn write(metrics: &[Metric], folder: &Path) -> Result<usize, WriteError> {
    let table = folder.join("metrics");
    let fresh = folder.join("metrics.new");
    let rows: Vec<Row<'_>> = metrics.iter().filter_map(row).collect();
    let keys = partition_keys(&rows);
    let mut parts: BTreeMap<PathBuf, Vec<&Metric>> = BTreeMap::new();
    for (metric, run) in &rows {
        parts.entry(folders(run, &keys)).or_default().push(metric);
    }
    remove(&fresh)?;
    for (part, metrics) in &parts {
        let folder = fresh.join(part);
        fs::create_dir_all(&folder).map_err(|error| WriteError::new(&folder, error))?;
        let path = folder.join("metrics.parquet");
        write_part(&path, metrics, &keys).map_err(|error| WriteError::new(&path, error))?;
    }
    // Otherwise, parts of an earlier sweep would be read together with this one.
    remove(&table)?;
    if !parts.is_empty() {
        fs::rename(&fresh, &table).map_err(|error| WriteError::new(&table, error))?;
    }
    Ok(rows.len())
}

/// Writes the metrics of one folder; the coordinates of the folder's name are not columns.
fn write_part(path: &Path, metrics: &[&Metric], keys: &[String]) -> Result<(), ParquetError> {
    let table = MetricTable::new(metrics.iter().copied());
    let mut file = ParquetTable::new(NewFile::create(path)?, &table.columns(keys))?;
    table.rows(keys).try_for_each(|row| file.row(row))?;
    Ok(file.finish()?.finish()?)
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
    let all = coordinates::keys_of(rows.iter().map(|(_, run)| run.coordinates.as_slice()));
    let count = |keys: &[String]| {
        let folders: BTreeSet<PathBuf> = rows.iter().map(|row| folders(row.1, keys)).collect();
        folders.len()
    };
    let fitting = (0..=all.len()).rev().find(|&length| count(&all[..length]) <= MAX_FOLDERS);
    all[..fitting.unwrap_or(0)].to_vec()
}

fn folders(run: &RunScope, keys: &[String]) -> PathBuf {
    let places = run.coordinates.iter().filter(|coordinate| keys.contains(&coordinate.key));
    places
        .map(|coordinate| {
            // The last part of a key, as in the names of recordings.
            let name = coordinates::last_part(&coordinate.key);
            format!("{name}={}", escaped(&coordinate.value))
        })
        .collect()
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
