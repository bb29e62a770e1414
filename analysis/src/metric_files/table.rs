//! Tables of metrics: one list of columns for `metrics.csv`, `metrics.parquet` and the table of a sweep.

use crate::input::coordinates::{AxisNames, CoordinateValue, value_of};
use crate::metric::{Metric, MetricScope, RunScope, SweepScope};
use crate::table::{Cell, CellKind, Column};

/// A column after those of the coordinates: its name, its type and its cell of a metric.
type Definition = (&'static str, CellKind, fn(&Metric) -> Cell);

/// The columns after those of the coordinates.
const COLUMNS: &[Definition] = {
    use CellKind::{Boolean, Integer, Number, Text};
    &[
        ("replicate", Integer, |metric| run(metric).map(|run| u64::from(run.replicate)).into()),
        ("metric", Text, |metric| metric.name().into()),
        ("value", Number, |metric| metric.value().into()),
        ("unit", Text, |metric| metric.unit().into()),
        ("standard_error", Number, |metric| metric.standard_error().into()),
        ("conditional_standard_error", Number, |metric| {
            metric.estimate.conditional_standard_error.into()
        }),
        ("degrees_of_freedom", Number, |metric| metric.estimate.degrees_of_freedom.into()),
        ("theory", Number, |metric| metric.theory_value().into()),
        ("theory_accuracy", Number, |metric| metric.theory.map(|theory| theory.accuracy).into()),
        ("theory_in_range", Boolean, |metric| metric.theory.map(|theory| theory.in_range()).into()),
        ("deviation_sigma", Number, |metric| metric.deviation_in_standard_errors().into()),
        ("applicable", Boolean, |metric| metric.is_applicable().into()),
        ("reason", Text, |metric| metric.reason_in_files().into()),
        ("scope", Text, |metric| if run(metric).is_some() { "run" } else { "sweep" }.into()),
        ("along", Text, |metric| sweep(metric).and_then(|sweep| sweep.along.clone()).into()),
        ("replicates", Integer, |metric| sweep(metric).map(|sweep| sweep.replicates as u64).into()),
        ("outcome", Text, |metric| run(metric).map(|run| run.outcome).into()),
        ("seed", Integer, |metric| run(metric).map(|run| run.seed).into()),
        ("file", Text, |metric| run(metric).map(|run| run.file.as_str()).into()),
        ("run_key", Text, |metric| run(metric).map(|run| run.origin.run_key.as_str()).into()),
        ("program_version", Text, |metric| {
            run(metric).map(|run| run.origin.program_version.as_str()).into()
        }),
        ("physics_version", Integer, |metric| {
            run(metric).map(|run| u64::from(run.origin.physics_version)).into()
        }),
    ]
};

fn run(metric: &Metric) -> Option<&RunScope> {
    match &metric.scope {
        MetricScope::Run(run) => Some(run),
        MetricScope::Sweep(_) => None,
    }
}

fn sweep(metric: &Metric) -> Option<&SweepScope> {
    match &metric.scope {
        MetricScope::Run(_) => None,
        MetricScope::Sweep(sweep) => Some(sweep),
    }
}

/// A table with one row per metric: first the coordinates, then the metric.
pub(crate) struct MetricTable<'a> {
    metrics: Vec<&'a Metric>,
    /// The columns of coordinates, with the key of each.
    axes: Vec<(String, Column)>,
}

impl<'a> MetricTable<'a> {
    /// The table of these metrics.
    pub(crate) fn new(metrics: impl IntoIterator<Item = &'a Metric>) -> Self {
        let metrics: Vec<&Metric> = metrics.into_iter().collect();
        let names = AxisNames::of(metrics.iter().map(|metric| metric.coordinates()));
        let is_taken = |name: &str| COLUMNS.iter().any(|(column, ..)| *column == name);
        let axes = names.iter().map(|(key, name)| {
            let name = if is_taken(name) { key } else { name };
            let coordinates = metrics.iter().flat_map(|metric| metric.coordinates());
            let mut values = coordinates.filter(|coordinate| coordinate.key == key);
            let is_number = values.all(|it| !matches!(value_of(it), CoordinateValue::Text(_)));
            let kind = if is_number { CellKind::Number } else { CellKind::Text };
            (key.to_owned(), Column::new(name, kind))
        });
        let axes = axes.collect();
        Self { metrics, axes }
    }

    /// The columns, without the coordinates of these keys.
    pub(crate) fn columns(&self, without: &[String]) -> Vec<Column> {
        let axes = self.axes(without).map(|(_, column)| column.clone());
        let fixed = COLUMNS.iter().map(|(name, kind, _)| Column::new(*name, *kind));
        axes.chain(fixed).collect()
    }

    /// The rows, in the order of the metrics, without the coordinates of these keys.
    pub(crate) fn rows(&self, without: &'a [String]) -> impl Iterator<Item = Vec<Cell>> + '_ {
        self.metrics.iter().map(move |metric| {
            let axes = self.axes(without).map(|(key, column)| {
                let mut coordinates = metric.coordinates().iter();
                let found = coordinates.find(|coordinate| coordinate.key == *key);
                found.map_or(Cell::Missing, |coordinate| {
                    match (value_of(coordinate), column.kind) {
                        (CoordinateValue::Integer(number), CellKind::Number) => {
                            (number as f64).into()
                        }
                        (CoordinateValue::Number(number), CellKind::Number) => number.into(),
                        _ => coordinate.value.as_str().into(),
                    }
                })
            });
            axes.chain(COLUMNS.iter().map(|(.., cell)| cell(metric))).collect()
        })
    }

    fn axes(&self, without: &[String]) -> impl Iterator<Item = &(String, Column)> {
        self.axes.iter().filter(move |(key, _)| !without.contains(key))
    }
}

/// The text of `metrics.csv`: one line per metric.
///
/// # Errors
/// Errors of the writer; none is expected.
pub(crate) fn to_csv<'a>(
    metrics: impl IntoIterator<Item = &'a Metric>,
) -> Result<String, csv::Error> {
    let table = MetricTable::new(metrics);
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(table.columns(&[]).iter().map(Column::text))?;
    for row in table.rows(&[]) {
        writer.write_record(row.iter().map(|cell| cell.text()))?;
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The bytes of `metrics.parquet`: the table of `metrics.csv`.
///
/// # Errors
/// Errors of the writer; none is expected.
#[cfg(feature = "parquet")]
pub(crate) fn to_parquet<'a>(
    metrics: impl IntoIterator<Item = &'a Metric>,
) -> Result<Vec<u8>, parquet::errors::ParquetError> {
    let table = MetricTable::new(metrics);
    let mut file = crate::table::parquet::ParquetTable::new(Vec::new(), &table.columns(&[]))?;
    table.rows(&[]).try_for_each(|row| file.row(row))?;
    file.finish()
}
