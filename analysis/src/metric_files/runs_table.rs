//! `runs.parquet`: the runs of an experiment as one table, one row per run.
//!
//! The columns are the coordinates of the sweep, what identifies the run, and two per metric: its value, and its standard error. Units and
//! definitions are stated once, as JSON in the metadata of the file. Equal recordings give equal bytes.

use crate::input::coordinates::{AxisNames, CoordinateValue, value_of};
use crate::metric::Definition;
use crate::metric_files::document::DefinitionEntry;
use crate::metric_files::run_row::RunRow;
use crate::models::metrics_of;
use crate::table::{Cell, CellKind, Column};
use kinetoscope_manifest::{Coordinate, unit_of_key};
use parquet::errors::ParquetError;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};
use std::ops::Range;

/// Name of the entry with the description among the file's metadata.
pub(crate) const DESCRIPTION: &str = "kinetoscope";
/// Version of the columns and of their description.
pub(crate) const RUNS_SCHEMA: u32 = 1;
/// The end of the name of a column with standard errors, after that of the metric.
pub(crate) const ERROR_SUFFIX: &str = ".standard_error";

/// A column after those of the coordinates: its name, its type and its cell of a run.
type RunColumn = (&'static str, CellKind, fn(&RunRow) -> Cell);

/// The columns between those of the coordinates and those of the metrics; before the last of these, there is that of the manifests.
const COLUMNS: &[RunColumn] = {
    use CellKind::{Integer, Text};
    &[
        ("replicate", Integer, |run| u64::from(run.replicate).into()),
        ("seed", Integer, |run| run.seed.into()),
        ("outcome", Text, |run| run.outcome.as_str().into()),
        ("outcome_detail", Text, |run| run.outcome_detail.clone().into()),
        ("frames", Integer, |run| run.frames.into()),
        ("end_time", CellKind::Number, |run| run.end_time.into()),
        ("messages", Text, |run| run.messages.map(|hash| hexadecimal(&hash)).into()),
        ("file", Text, |run| run.file.as_str().into()),
        ("run_key", Text, |run| run.run_key.as_str().into()),
        ("program_version", Text, |run| run.program_version.as_str().into()),
        ("physics_version", Integer, |run| u64::from(run.physics_version).into()),
        (DETAILS, Text, |run| hexadecimal(&run.details).into()),
    ]
};

/// The column with what `kinetoscope analyze` needs in addition to values and standard errors.
pub(crate) const DETAILS: &str = "details";
/// The column with the canonical manifests.
pub(crate) const MANIFEST: &str = "manifest";

/// What the metadata of the file states about the table.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct RunsDescription {
    /// Version of the columns.
    pub(crate) schema: u32,
    /// The experiment's name.
    pub(crate) experiment: String,
    /// Version of the program that derived the metrics.
    pub(crate) analysis_version: String,
    /// The columns of coordinates.
    pub(crate) coordinates: BTreeMap<String, CoordinateColumn>,
    /// The definitions of the metrics, by the name of their column.
    pub(crate) metrics: BTreeMap<String, DefinitionEntry>,
}

/// A column of coordinates.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct CoordinateColumn {
    /// The dotted key of the manifest.
    pub(crate) key: String,
    /// "1" for a pure number, empty for a word.
    pub(crate) unit: String,
}

/// Rows of an experiment in its order, some at a time.
pub(crate) type ReadRows<'a> = &'a mut dyn FnMut(Range<usize>) -> io::Result<Cow<'a, [RunRow]>>;

/// The columns of a table of runs.
struct RunsTable {
    /// The columns of coordinates, with the key of each.
    axes: Vec<(String, Column)>,
    metrics: Vec<&'static Definition>,
}

/// What the columns of a table follow from.
#[derive(Default)]
struct Found {
    /// The points of the sweep.
    places: Vec<Vec<Coordinate>>,
    /// The names of the metrics that have a value or an error.
    metrics: BTreeSet<&'static str>,
    models: BTreeSet<String>,
}

impl Found {
    fn add(&mut self, row: &RunRow) {
        if self.places.last() != Some(&row.coordinates) {
            self.places.push(row.coordinates.clone());
        }
        self.metrics.extend(row.definitions().map(|metric| metric.name));
        if !self.models.contains(&row.model) {
            self.models.insert(row.model.clone());
        }
    }
}

impl RunsTable {
    /// The columns of these rows.
    fn new(found: &Found) -> Self {
        let names = AxisNames::of(found.places.iter().map(Vec::as_slice));
        let axis = |(key, name): (&str, &str)| {
            let is_taken = name == MANIFEST || COLUMNS.iter().any(|(column, ..)| *column == name);
            let name = if is_taken { key } else { name };
            (key.to_owned(), Column::new(name, kind_of_axis(&found.places, key)))
        };
        // In the order of the definitions, which is that of rows that were read from a table as well.
        let mut metrics: Vec<&'static Definition> = Vec::new();
        for known in found.models.iter().flat_map(|model| metrics_of(model)) {
            if found.metrics.contains(known.name) && !metrics.iter().any(|it| it.name == known.name)
            {
                metrics.push(known);
            }
        }
        Self { axes: names.iter().map(axis).collect(), metrics }
    }

    /// The columns.
    fn columns(&self) -> Vec<Column> {
        let axes = self.axes.iter().map(|(_, column)| column.clone());
        let fixed = COLUMNS.iter().map(|(name, kind, _)| Column::new(*name, *kind));
        let metrics = self.metrics.iter().flat_map(|metric| {
            let error = format!("{}{ERROR_SUFFIX}", metric.name);
            [metric.name.to_owned(), error].map(|name| Column::new(name, CellKind::Number))
        });
        let manifest = [Column::new(MANIFEST, CellKind::Text)];
        axes.chain(fixed).chain(manifest).chain(metrics).collect()
    }

    /// The cell of a run in a column, counted from 0. `manifest` returns its canonical manifest.
    fn cell(&self, run: &RunRow, column: usize, manifest: impl Fn() -> String) -> Cell {
        if let Some((key, axis)) = self.axes.get(column) {
            return coordinate(run, key, axis.kind);
        }
        let column = column - self.axes.len();
        if let Some((.., cell)) = COLUMNS.get(column) {
            return cell(run);
        }
        if column == COLUMNS.len() {
            return manifest().into();
        }
        let column = column - COLUMNS.len() - 1;
        let definition = self.metrics.get(column / 2);
        definition.map_or(Cell::Missing, |metric| run.value(metric)[column % 2].into())
    }

    /// The description as JSON.
    ///
    /// # Errors
    /// Errors of the serializer; none is expected.
    fn description(&self, experiment: &str) -> serde_json::Result<String> {
        let coordinate = |(key, column): &(String, Column)| {
            let unit = unit_of_key(key).to_owned();
            (column.name.clone(), CoordinateColumn { key: key.clone(), unit })
        };
        serde_json::to_string(&RunsDescription {
            schema: RUNS_SCHEMA,
            experiment: experiment.to_owned(),
            analysis_version: env!("CARGO_PKG_VERSION").to_owned(),
            coordinates: self.axes.iter().map(coordinate).collect(),
            metrics: self.metrics.iter().map(|metric| DefinitionEntry::of(metric)).collect(),
        })
    }
}

/// The type of a coordinate: whole numbers if all values are, numbers if all are, else text.
fn kind_of_axis(places: &[Vec<Coordinate>], key: &str) -> CellKind {
    let all = places.iter().flatten().filter(|it| it.key == key);
    all.fold(CellKind::Integer, |kind, coordinate| match (value_of(coordinate), kind) {
        (_, CellKind::Text) | (CoordinateValue::Text(_), _) => CellKind::Text,
        (CoordinateValue::Integer(_), kind) => kind,
        (CoordinateValue::Number(_), _) => CellKind::Number,
    })
}

/// The coordinate of a run as a cell of this type.
fn coordinate(run: &RunRow, key: &str, kind: CellKind) -> Cell {
    let found = run.coordinates.iter().find(|coordinate| coordinate.key == key);
    found.map_or(Cell::Missing, |coordinate| match (value_of(coordinate), kind) {
        (_, CellKind::Text) | (CoordinateValue::Text(_), _) => coordinate.value.as_str().into(),
        (CoordinateValue::Integer(number), CellKind::Number) => (number as f64).into(),
        (CoordinateValue::Integer(number), _) => Cell::Integer(number),
        (CoordinateValue::Number(number), _) => number.into(),
    })
}

fn hexadecimal(bytes: &[u8]) -> String {
    // A table of a million rows has some 10^9 digits.
    let digit = |number: u8| char::from_digit(number.into(), 16);
    bytes.iter().flat_map(|byte| [byte >> 4, byte & 15]).filter_map(digit).collect()
}

/// Rows that are read at once to find the columns.
const ROWS_AT_ONCE: usize = 1 << 12;

/// Writes `runs.parquet`, of which only a group of rows is in the memory, and returns the output. `manifest` returns the canonical manifest
/// of a row.
///
/// # Errors
/// Rows that cannot be read, and an output that cannot be written.
pub(crate) fn to_parquet<W: Write + Send>(
    output: W,
    experiment: &str,
    rows: usize,
    read: ReadRows<'_>,
    manifest: &(dyn Fn(usize) -> String + Sync),
) -> Result<W, ParquetError> {
    let mut found = Found::default();
    for first in (0..rows).step_by(ROWS_AT_ONCE) {
        read(first..rows.min(first + ROWS_AT_ONCE))?.iter().for_each(|row| found.add(row));
    }
    let table = RunsTable::new(&found);
    let description = table.description(experiment);
    let description = description.map_err(|error| ParquetError::General(error.to_string()))?;
    let metadata = (DESCRIPTION, description.as_str());
    let group = |range: Range<usize>| Ok((range.start, read(range)?));
    let cell = |(first, rows): &(usize, Cow<'_, [RunRow]>), row: usize, column: usize| {
        table.cell(&rows[row], column, || manifest(first + row))
    };
    crate::table::parquet::write(output, &table.columns(), metadata, rows, group, cell)
}
