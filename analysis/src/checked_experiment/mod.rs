//! The checked metrics of an experiment, with which later runs are compared.

use crate::checks::{checked_metrics, compare, subject};
use crate::input;
use crate::metric::{Metric, MetricScope};
use crate::number_text::{plus_minus, significant};
use crate::report::{AnalysisOptions, analyze, applying};
use kinetoscope_manifest::Check;
use std::collections::BTreeSet;
use std::path::Path;

/// Metrics that are kept of an experiment.
const MOST_METRICS: usize = 4;
/// What a reader of a changed experiment compares.
#[derive(Clone, Debug, Default)]
pub struct CheckedExperiment {
    /// The answer to its question, in one line; may be empty.
    pub answer: String,
    /// Checks that fail, each in one line.
    pub failed_checks: Vec<String>,
    /// The first metric of each check, then the others, up to four; without checks, metrics of the first run.
    pub values: Vec<CheckedValue>,
}

/// A metric that a check uses.
#[derive(Clone, Debug)]
pub struct CheckedValue {
    /// The metric and its part of the sweep.
    pub name: String,
    /// The value.
    pub value: f64,
    /// Its standard error, if it is known.
    pub standard_error: Option<f64>,
    /// A difference below this is a rounding error.
    pub rounding: f64,
    /// Whether its checks pass; `None` without a check.
    pub passes: Option<bool>,
}

/// Analyzes the recordings of a folder, without plots of single runs and without a cache.
///
/// # Errors
/// A folder without readable recordings, as text.
pub fn checked_experiment(folder: &Path) -> Result<CheckedExperiment, String> {
    let sources =
        input::sources_and_tables(&[folder.to_owned()]).map_err(|error| error.message.clause())?;
    let Some(mut source) = sources.into_iter().next() else {
        return Ok(CheckedExperiment::default());
    };
    let options = AnalysisOptions::default();
    let report = analyze(&mut source, &options);
    let checks = applying(&source, &options);
    let failed = report.check_results.iter().filter(|result| !result.passed);
    Ok(CheckedExperiment {
        answer: report.answer.text(),
        failed_checks: failed.map(|result| result.text()).collect(),
        values: values(&checks, &report.metrics),
    })
}

fn values(checks: &[&Check], metrics: &[Metric]) -> Vec<CheckedValue> {
    let by_check: Vec<Vec<&Metric>> =
        checks.iter().map(|check| checked_metrics(check, metrics)).collect();
    let rounds = by_check.iter().map(Vec::len).max().unwrap_or(0);
    let checked = (0..rounds).flat_map(|round| by_check.iter().filter_map(move |of| of.get(round)));
    let first_run = metrics.iter().find(|metric| matches!(metric.scope, MetricScope::Run(_)));
    let is_of_first_run =
        |metric: &&Metric| first_run.is_some_and(|first| first.scope == metric.scope);
    let mut seen = BTreeSet::new();
    let mut chosen: Vec<&Metric> = if rounds > 0 {
        checked.copied().collect()
    } else {
        metrics.iter().filter(is_of_first_run).collect()
    };
    chosen.retain(|metric| metric.value().is_finite() && seen.insert(subject(metric)));
    let value = |metric: &&Metric| {
        let applies =
            |check: &&&Check| check.metric == metric.name() && check.selects(metric.coordinates());
        let results = checks.iter().filter(applies).map(|check| compare(check, metric).passed);
        CheckedValue {
            name: subject(metric),
            value: metric.value(),
            standard_error: metric.standard_error(),
            rounding: metric.rounding,
            passes: results.reduce(|all, passed| all && passed),
        }
    };
    chosen.iter().take(MOST_METRICS).map(value).collect()
}

/// A value with its standard error, such as "24.5 ± 2.2", or with this number of digits.
#[must_use]
pub fn value_text(value: f64, standard_error: Option<f64>, digits: u8) -> String {
    standard_error
        .and_then(|error| plus_minus(value, error))
        .unwrap_or_else(|| significant(value, digits))
}
