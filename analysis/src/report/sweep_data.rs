//! The data of a sweep for the script of `report.html`: every metric at every point.

use super::AnalysisReport;
use super::plot_data::rounded;
use crate::input::coordinates::{CoordinateValue, keys_of, last_part, shown_value, value_of};
use crate::sweep;
use kinetoscope_manifest::unit_of_key;
use serde::Serialize;

/// Maximum number of points; more would make the page too large.
const MOST_POINTS: usize = 2000;
/// Significant digits of values.
const DIGITS: i32 = 6;
/// Significant digits of standard errors.
const DIGITS_OF_ERROR: i32 = 3;

/// All metrics at all points of a sweep.
#[derive(Serialize)]
pub(super) struct SweepData {
    keys: Vec<KeyData>,
    /// The coordinates of each point, in the order of the keys.
    points: Vec<Vec<Option<CoordinateValue>>>,
    /// The number of runs of each point.
    runs: Vec<usize>,
    metrics: Vec<MetricData>,
}

#[derive(Serialize)]
struct KeyData {
    name: String,
    unit: &'static str,
}

#[derive(Serialize)]
struct MetricData {
    name: &'static str,
    unit: &'static str,
    /// The value at each point; `None` where there is none.
    y: Vec<Option<f64>>,
    /// Standard errors; empty without any.
    e: Vec<Option<f64>>,
    /// Theoretical values within the ranges of their laws; empty without any.
    t: Vec<Option<f64>>,
}

impl SweepData {
    /// The data of a sweep; `None` for fewer than two points, and for more than a page can hold.
    pub(super) fn of(report: &AnalysisReport) -> Option<Self> {
        let points = sweep::points(&report.runs);
        if !(2..=MOST_POINTS).contains(&points.len()) {
            return None;
        }
        let keys = keys_of(points.iter().map(|point| point.coordinates.as_slice()));
        if keys.is_empty() {
            return None;
        }
        let mut metrics: Vec<MetricData> = Vec::new();
        for measurement in
            points.iter().flat_map(|point| &point.runs).flat_map(|run| &run.measurements)
        {
            if metrics.iter().any(|metric| metric.name == measurement.name()) {
                continue;
            }
            let mut metric =
                MetricData::new(measurement.definition.name, measurement.definition.unit);
            points.iter().for_each(|point| metric.push(point));
            metrics.push(metric);
        }
        metrics.retain_mut(MetricData::has_values);
        let coordinate = |point: &sweep::SweepPoint<'_>, key: &String| {
            let found = point.coordinates.iter().find(|coordinate| coordinate.key == *key)?;
            Some(match value_of(found) {
                CoordinateValue::Text(_) => CoordinateValue::Text(shown_value(found)),
                number => number,
            })
        };
        Some(Self {
            points: points
                .iter()
                .map(|point| keys.iter().map(|key| coordinate(point, key)).collect())
                .collect(),
            runs: points.iter().map(|point| point.runs.len()).collect(),
            keys: keys
                .iter()
                .map(|key| KeyData { name: last_part(key).to_owned(), unit: unit_of_key(key) })
                .map(|key| KeyData { unit: if key.unit == "1" { "" } else { key.unit }, ..key })
                .collect(),
            metrics,
        })
    }

    /// The names of the metrics.
    pub(super) fn metrics(&self) -> impl Iterator<Item = &str> {
        self.metrics.iter().map(|metric| metric.name)
    }

    /// The names of the swept keys.
    pub(super) fn keys(&self) -> impl Iterator<Item = &str> {
        self.keys.iter().map(|key| key.name.as_str())
    }
}

impl MetricData {
    fn new(name: &'static str, unit: &'static str) -> Self {
        let unit = if unit == "1" { "" } else { unit };
        Self { name, unit, y: Vec::new(), e: Vec::new(), t: Vec::new() }
    }

    /// Adds the mean at a point.
    fn push(&mut self, point: &sweep::SweepPoint<'_>) {
        let mean = point.mean_of(self.name);
        let (value, error, theory) = mean.map_or((None, None, None), |(estimate, theory, _)| {
            (
                Some(estimate.value),
                estimate.standard_error,
                theory.and_then(|theory| theory.applicable()),
            )
        });
        self.y.push(value.and_then(|value| rounded(value, 0.0, DIGITS)));
        self.e.push(error.and_then(|error| rounded(error, 0.0, DIGITS_OF_ERROR)));
        self.t.push(theory.and_then(|theory| rounded(theory, 0.0, DIGITS)));
    }

    /// Whether there is a value; columns without one are emptied.
    fn has_values(&mut self) -> bool {
        for column in [&mut self.e, &mut self.t] {
            if column.iter().all(Option::is_none) {
                column.clear();
            }
        }
        self.y.iter().any(Option::is_some)
    }
}
