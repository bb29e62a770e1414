//! The data of a sweep for the script of `report.html`: every metric at every point.

use super::AnalysisReport;
use super::plot_data::rounded;
use crate::input::coordinates::{CoordinateValue, keys_of, last_part, shown_value, value_of};
use crate::input::key_words::words_and_unit;
use crate::metric::Definition;
use crate::sweep;
use crate::sweep::figures::capitalized;
use crate::sweep::samples::typographic_unit;
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

/// A swept key in words.
#[derive(Serialize)]
struct KeyData {
    name: String,
    unit: String,
}

/// A metric in words.
#[derive(Serialize)]
struct MetricData {
    #[serde(skip)]
    metric: &'static str,
    name: String,
    unit: String,
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
            if metrics.iter().any(|known| known.metric == measurement.name()) {
                continue;
            }
            let mut metric = MetricData::new(measurement.definition);
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
                .map(|key| {
                    let (name, unit) = words_and_unit(last_part(key));
                    let unit = if unit.is_empty() { unit_of_key(key) } else { unit };
                    KeyData { name, unit: typographic_unit(unit) }
                })
                .collect(),
            metrics,
        })
    }

    /// The metrics with their units.
    pub(super) fn metrics(&self) -> impl Iterator<Item = String> {
        self.metrics.iter().map(|metric| with_unit(&metric.name, &metric.unit))
    }

    /// The swept keys with their units.
    pub(super) fn keys(&self) -> impl Iterator<Item = String> {
        self.keys.iter().map(|key| with_unit(&key.name, &key.unit))
    }
}

fn with_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
}

impl MetricData {
    fn new(definition: &Definition) -> Self {
        let (name, unit) = (capitalized(definition.label), typographic_unit(definition.unit));
        Self { metric: definition.name, name, unit, y: Vec::new(), e: Vec::new(), t: Vec::new() }
    }

    /// Adds the mean at a point.
    fn push(&mut self, point: &sweep::SweepPoint<'_>) {
        let mean = point.mean_of(self.metric);
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
