//! Metrics: definition, value with a standard error, theoretical value, and the run or sweep described.

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

/// A value with its definition and scope.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// The definition.
    pub definition: &'static Definition,
    /// The value.
    pub value: f64,
    /// The standard error, if known.
    pub standard_error: Option<f64>,
    /// The theoretical value, if there is one.
    pub theory: Option<f64>,
    /// A deviation below this is a rounding error.
    pub rounding: f64,
    /// How the value is derived, and the law of the theoretical value.
    pub source: String,
    /// The run or the part of the sweep that the value describes.
    pub scope: MetricScope,
}

/// Deviation of a value from theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deviation {
    /// Within rounding errors.
    Rounding,
    /// In standard errors.
    StandardErrors(f64),
    /// The difference, if no standard error is known.
    Bare(f64),
}

/// Deviations below this fraction of the theoretical value are rounding errors.
const ROUNDING_SHARE: f64 = 1e-9;

impl Metric {
    /// The metric's name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.definition.name
    }

    /// The metric's unit; empty for the model's own.
    #[must_use]
    pub const fn unit(&self) -> &'static str {
        self.definition.unit
    }

    /// Deviation from theory; `None` without a theoretical value.
    #[must_use]
    pub fn deviation(&self) -> Option<Deviation> {
        let theory = self.theory?;
        let apart = self.value - theory;
        let rounding = self.rounding.max(ROUNDING_SHARE * theory.abs());
        Some(match self.standard_error {
            _ if apart.abs() <= rounding => Deviation::Rounding,
            // A standard error within rounding is not a measure of the deviation.
            Some(error) if error > rounding => Deviation::StandardErrors(apart / error),
            _ => Deviation::Bare(apart),
        })
    }

    /// Deviation from theory in standard errors, if a standard error is known.
    #[must_use]
    pub fn deviation_in_standard_errors(&self) -> Option<f64> {
        match self.deviation() {
            Some(Deviation::StandardErrors(deviation)) => Some(deviation),
            _ => None,
        }
    }
}

/// The run or the part of a sweep that a metric describes.
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
    /// The run's coordinates in the sweep.
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
    /// The key along which a fit was made; `None` for the mean over a point's replicates.
    pub along: Option<String>,
    /// The coordinates that all runs of this part share.
    #[serde(serialize_with = "as_map")]
    pub coordinates: Vec<Coordinate>,
    /// Number of averaged replicates.
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
    /// The coordinates of the run or of the part of the sweep.
    #[must_use]
    pub fn coordinates(&self) -> &[Coordinate] {
        match &self.scope {
            MetricScope::Run(run) => &run.coordinates,
            MetricScope::Sweep(sweep) => &sweep.coordinates,
        }
    }
}
