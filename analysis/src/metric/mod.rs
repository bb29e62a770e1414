//! Metrics: what each is, its value with a standard error, the theoretical value, and the run or sweep that it describes.

pub mod definition;
pub mod law;
pub mod measurement;

pub use definition::Definition;
pub use law::Law;
pub use measurement::Measurement;

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
    pub scope: MetricScope,
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

    /// Deviation from theory in standard errors, if it is known in these.
    #[must_use]
    pub fn deviation_in_standard_errors(&self) -> Option<f64> {
        match self.deviation() {
            Some(Deviation::StandardErrors(deviation)) => Some(deviation),
            _ => None,
        }
    }
}

/// What a metric is about.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MetricScope {
    /// One run.
    Run(RunScope),
    /// A point of the sweep, or a fit along one of its axes.
    Sweep(SweepScope),
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunScope {
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
pub struct SweepScope {
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
        match &self.scope {
            MetricScope::Run(run) => &run.coordinates,
            MetricScope::Sweep(sweep) => &sweep.coordinates,
        }
    }
}
