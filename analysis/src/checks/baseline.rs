//! Comparison of metrics with those of an earlier analysis: by statistics, not by equality.

use crate::checks::{CheckKind, CheckResult, in_unit, subject};
use crate::metric::{Metric, MetricScope, SCHEMA};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Maximum difference in combined standard errors. Chance exceeds it for one in 16,000 unchanged metrics.
const MAX_STANDARD_ERRORS: f64 = 4.0;
/// Differences below this fraction of the value are rounding errors.
const ROUNDING_FRACTION: f64 = 1e-9;

/// The metrics of an earlier analysis.
#[derive(Debug, Deserialize)]
pub(crate) struct Baseline {
    schema: u32,
    /// The name of the experiment.
    pub(crate) experiment: String,
    metrics: Vec<BaselineMetric>,
}

#[derive(Debug, Deserialize)]
struct BaselineMetric {
    name: String,
    value: Option<f64>,
    standard_error: Option<f64>,
    run: Option<BaselineRun>,
    sweep: Option<BaselineSweep>,
}

#[derive(Debug, Deserialize)]
struct BaselineRun {
    coordinates: BTreeMap<String, String>,
    replicate: u32,
}

#[derive(Debug, Deserialize)]
struct BaselineSweep {
    along: Option<String>,
    coordinates: BTreeMap<String, String>,
}

/// Identifies a metric independently of its recording's file name, which changes with the physics.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct MetricId {
    name: String,
    coordinates: BTreeMap<String, String>,
    replicate: Option<u32>,
    along: Option<String>,
}

impl Baseline {
    /// Reads a `metrics.json`.
    ///
    /// # Errors
    /// A text that is not a `metrics.json`, or one of another schema, with the user's next step.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        let again = "write it again with this version of analyze-recordings";
        let read: Self = serde_json::from_str(text)
            .map_err(|error| format!("is no metrics.json ({error}): {again}"))?;
        if read.schema == SCHEMA {
            Ok(read)
        } else {
            Err(format!("has schema {}, this version reads {SCHEMA}: {again}", read.schema))
        }
    }

    /// Compares all metrics: one result per metric with a standard error or that is missing now, and one note per
    /// changed metric without a standard error.
    pub(crate) fn compare_all(&self, metrics: &[Metric]) -> (Vec<CheckResult>, Vec<String>) {
        let now: BTreeMap<MetricId, &Metric> =
            metrics.iter().map(|metric| (subject_of(metric), metric)).collect();
        let (mut check_results, mut notes) = (Vec::new(), Vec::new());
        for earlier in &self.metrics {
            let of = earlier.subject();
            match now.get(&of) {
                Some(metric) => match compare(earlier, metric) {
                    BaselineComparison::Checked(result) => check_results.push(result),
                    BaselineComparison::Changed(note) => notes.push(note),
                    BaselineComparison::Same => {}
                },
                None => check_results.push(missing(&of)),
            }
        }
        (check_results, notes)
    }
}

impl BaselineMetric {
    fn subject(&self) -> MetricId {
        let name = self.name.clone();
        match (&self.run, &self.sweep) {
            (Some(run), _) => MetricId {
                name,
                coordinates: run.coordinates.clone(),
                replicate: Some(run.replicate),
                along: None,
            },
            (None, Some(sweep)) => MetricId {
                name,
                coordinates: sweep.coordinates.clone(),
                replicate: None,
                along: sweep.along.clone(),
            },
            (None, None) => {
                MetricId { name, coordinates: BTreeMap::new(), replicate: None, along: None }
            }
        }
    }
}

fn subject_of(metric: &Metric) -> MetricId {
    let (replicate, along) = match &metric.scope {
        MetricScope::Run(run) => (Some(run.replicate), None),
        MetricScope::Sweep(sweep) => (None, sweep.along.clone()),
    };
    let places = metric.coordinates().iter();
    MetricId {
        name: metric.name().to_owned(),
        coordinates: places
            .map(|coordinate| (coordinate.key.clone(), coordinate.value.clone()))
            .collect(),
        replicate,
        along,
    }
}

enum BaselineComparison {
    Checked(CheckResult),
    Changed(String),
    Same,
}

fn compare(earlier: &BaselineMetric, metric: &Metric) -> BaselineComparison {
    let before = earlier.value.unwrap_or(f64::NAN);
    let difference = metric.value - before;
    let rounding = metric.rounding + ROUNDING_FRACTION * before.abs();
    let same = difference.abs() <= rounding || (before.is_nan() && !metric.value.is_finite());
    let errors = [earlier.standard_error, metric.standard_error];
    let numbers = format!("{}, before {}", in_unit(metric.value, metric), in_unit(before, metric));
    if errors == [None, None] {
        return if same {
            BaselineComparison::Same
        } else {
            let subject = subject(metric);
            BaselineComparison::Changed(format!(
                "{subject} has changed and is not checked, because it has no standard error: {numbers}"
            ))
        };
    }
    let error = errors.map(|error| error.unwrap_or(0.0));
    let combined = error[0].hypot(error[1]);
    let passed = same || difference.abs() <= MAX_STANDARD_ERRORS * combined;
    let finding = format!(
        "{numbers}: {:.1} of {MAX_STANDARD_ERRORS} combined standard errors",
        if same { 0.0 } else { difference.abs() / combined }
    );
    BaselineComparison::Checked(CheckResult {
        passed,
        kind: CheckKind::Baseline,
        subject: subject(metric),
        requirement: "equal to the baseline".to_owned(),
        finding,
        line: 0,
        seconds: 0.0,
    })
}

fn missing(of: &MetricId) -> CheckResult {
    let places = of.coordinates.iter().map(|(key, value)| format!("{key} = {value}"));
    let replicate = of.replicate.filter(|replicate| *replicate > 0);
    let replicate = replicate.map(|replicate| format!("replicate = {replicate}"));
    let places = places.chain(replicate).collect::<Vec<_>>().join(", ");
    let at = if places.is_empty() { places } else { format!(" at {places}") };
    CheckResult {
        passed: false,
        kind: CheckKind::Baseline,
        subject: format!("{}{at}", of.name),
        requirement: "in the baseline".to_owned(),
        line: 0,
        seconds: 0.0,
        finding: "the baseline contains it, and this analysis does not".to_owned(),
    }
}
