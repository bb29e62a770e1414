//! `metrics.json` and `metrics.csv`.

use crate::input::coordinates;
use crate::metric::{Metric, MetricScope, SCHEMA};
use serde::Serialize;

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    experiment: &'a str,
    model: &'a str,
    metrics: Vec<Entry<'a>>,
}

/// A metric in the file.
#[derive(Serialize)]
struct Entry<'a> {
    name: &'a str,
    /// Null if it is not finite.
    value: f64,
    unit: &'a str,
    standard_error: Option<f64>,
    theory: Option<f64>,
    deviation_in_standard_errors: Option<f64>,
    source: &'a str,
    #[serde(flatten)]
    scope: &'a MetricScope,
}

impl<'a> Entry<'a> {
    fn of(metric: &'a Metric) -> Self {
        Self {
            name: metric.name(),
            value: metric.value,
            unit: metric.unit(),
            standard_error: metric.standard_error,
            theory: metric.theory,
            deviation_in_standard_errors: metric.deviation_in_standard_errors(),
            source: &metric.source,
            scope: &metric.scope,
        }
    }
}

/// The text of `metrics.json`; equal recordings give equal bytes.
///
/// # Errors
/// Errors of the serializer; none is expected.
pub(crate) fn to_json(
    experiment: &str,
    model: &str,
    metrics: &[Metric],
) -> serde_json::Result<String> {
    let metrics = metrics.iter().map(Entry::of).collect();
    let document = Document { schema: SCHEMA, experiment, model, metrics };
    serde_json::to_string_pretty(&document).map(|text| text + "\n")
}

/// The text of `metrics.csv`: one line per metric.
///
/// # Errors
/// Errors of the writer; none is expected.
pub(crate) fn to_csv(metrics: &[Metric]) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "name",
        "value",
        "unit",
        "standard_error",
        "theory",
        "deviation_in_standard_errors",
        "scope",
        "coordinates",
        "along",
        "replicate",
        "replicates",
        "file",
        "outcome",
        "source",
    ])?;
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    for metric in metrics {
        let places = coordinates::text(metric.coordinates());
        let (scope, along, replicate, replicates, file, outcome) = match &metric.scope {
            MetricScope::Run(run) => {
                let replicate = run.replicate.to_string();
                ("run", "", replicate, String::new(), run.file.as_str(), run.outcome.as_str())
            }
            MetricScope::Sweep(sweep) => {
                let along = sweep.along.as_deref().unwrap_or("");
                ("sweep", along, String::new(), sweep.replicates.to_string(), "", "")
            }
        };
        writer.write_record([
            metric.name(),
            &metric.value.to_string(),
            metric.unit(),
            &number(metric.standard_error),
            &number(metric.theory),
            &number(metric.deviation_in_standard_errors()),
            scope,
            &places,
            along,
            &replicate,
            &replicates,
            file,
            outcome,
            &metric.source,
        ])?;
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
