//! All numbers of an experiment, as JSON and as CSV.

use crate::catalog::Definition;
use crate::coordinates;
use crate::run::RunAnalysis;
use kinetoscope_manifest::Coordinate;
use serde::Serialize;
use std::collections::BTreeMap;

/// Version of the layout of `metrics.json`.
pub const SCHEMA: u32 = 1;

/// A number and what it is about.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// What it is.
    pub definition: &'static Definition,
    /// The number.
    pub value: f64,
    /// One standard error, where it is known.
    pub standard_error: Option<f64>,
    /// What theory says, where there is one.
    pub theory: Option<f64>,
    /// A distance from theory below this is rounding.
    pub rounding: f64,
    /// How it was found, and the law behind theory's value.
    pub source: String,
    /// Which run, or which part of the sweep.
    pub place: Place,
}

/// How far a number is from theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deviation {
    /// No further than rounding takes it.
    Rounding,
    /// So many standard errors.
    StandardErrors(f64),
    /// The difference, where no standard error is known.
    Bare(f64),
}

/// Differences below this share of theory's value are rounding.
const ROUNDING_SHARE: f64 = 1e-9;

impl Metric {
    /// Its name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.definition.name
    }

    /// Its unit; empty for the model's own.
    #[must_use]
    pub const fn unit(&self) -> &'static str {
        self.definition.unit
    }

    /// How far it is from theory; `None` where that says nothing.
    #[must_use]
    pub fn deviation(&self) -> Option<Deviation> {
        let theory = self.theory?;
        let apart = self.value - theory;
        let rounding = self.rounding.max(ROUNDING_SHARE * theory.abs());
        Some(match self.standard_error {
            _ if apart.abs() <= rounding => Deviation::Rounding,
            // An error that is itself rounding measures nothing.
            Some(error) if error > rounding => Deviation::StandardErrors(apart / error),
            _ => Deviation::Bare(apart),
        })
    }
}

/// What a metric is about.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// One run.
    Run(RunPlace),
    /// A point of the sweep, or a fit along one of its axes.
    Sweep(SweepPlace),
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunPlace {
    /// The recording's file name.
    pub file: String,
    /// Where it lies in the sweep.
    #[serde(serialize_with = "as_map")]
    pub coordinates: Vec<Coordinate>,
    /// Number of the replicate.
    pub replicate: u32,
    /// How the run ended.
    pub outcome: String,
}

/// A part of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SweepPlace {
    /// The key that a fit runs along; none for the mean over a point's replicates.
    pub along: Option<String>,
    /// The coordinates that are the same for all runs of this part.
    #[serde(serialize_with = "as_map")]
    pub coordinates: Vec<Coordinate>,
    /// Replicates that the number is a mean of.
    pub replicates: usize,
}

fn as_map<S: serde::Serializer>(
    coordinates: &[Coordinate],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let pairs: BTreeMap<&str, &str> =
        coordinates.iter().map(|place| (place.key.as_str(), place.value.as_str())).collect();
    pairs.serialize(serializer)
}

impl Metric {
    /// The coordinates of its run or part of the sweep.
    #[must_use]
    pub fn coordinates(&self) -> &[Coordinate] {
        match &self.place {
            Place::Run(run) => &run.coordinates,
            Place::Sweep(sweep) => &sweep.coordinates,
        }
    }
}

/// The metrics of a run.
pub fn of_run(run: &RunAnalysis) -> impl Iterator<Item = Metric> + '_ {
    run.measurements.iter().map(|measurement| Metric {
        definition: measurement.definition,
        value: measurement.estimate.value,
        standard_error: measurement.estimate.standard_error,
        theory: measurement.theory,
        rounding: measurement.definition.rounding,
        source: measurement.source(),
        place: Place::Run(RunPlace {
            file: run.file.clone(),
            coordinates: run.coordinates.clone(),
            replicate: run.manifest.replicate,
            outcome: run.ending.text(),
        }),
    })
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    experiment: &'a str,
    model: &'a str,
    metrics: Vec<Entry<'a>>,
}

/// A metric as it stands in the file.
#[derive(Serialize)]
struct Entry<'a> {
    name: &'a str,
    /// Null where it is not finite.
    value: f64,
    unit: &'a str,
    standard_error: Option<f64>,
    theory: Option<f64>,
    deviation_in_standard_errors: Option<f64>,
    source: &'a str,
    #[serde(flatten)]
    place: &'a Place,
}

impl<'a> Entry<'a> {
    fn of(metric: &'a Metric) -> Self {
        Self {
            name: metric.name(),
            value: metric.value,
            unit: metric.unit(),
            standard_error: metric.standard_error,
            theory: metric.theory,
            deviation_in_standard_errors: in_standard_errors(metric),
            source: &metric.source,
            place: &metric.place,
        }
    }
}

pub(crate) fn in_standard_errors(metric: &Metric) -> Option<f64> {
    match metric.deviation() {
        Some(Deviation::StandardErrors(deviation)) => Some(deviation),
        _ => None,
    }
}

/// The text of `metrics.json`: the same recordings give the same bytes.
///
/// # Errors
/// None that is known; the serializer's own.
pub fn to_json(experiment: &str, model: &str, metrics: &[Metric]) -> serde_json::Result<String> {
    let metrics = metrics.iter().map(Entry::of).collect();
    let document = Document { schema: SCHEMA, experiment, model, metrics };
    serde_json::to_string_pretty(&document).map(|text| text + "\n")
}

/// The text of `metrics.csv`: one line a metric.
///
/// # Errors
/// None that is known; the writer's own.
pub fn to_csv(metrics: &[Metric]) -> Result<String, csv::Error> {
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
        let (scope, along, replicate, replicates, file, outcome) = match &metric.place {
            Place::Run(run) => {
                let replicate = run.replicate.to_string();
                ("run", "", replicate, String::new(), run.file.as_str(), run.outcome.as_str())
            }
            Place::Sweep(sweep) => {
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
            &number(in_standard_errors(metric)),
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
