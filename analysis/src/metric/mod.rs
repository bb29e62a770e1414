//! Metrics: definition, value with a standard error, theoretical value, and the run or sweep described.

pub(crate) mod definition;
pub(crate) mod law;
pub(crate) mod measurement;
pub(crate) mod symbols;

pub use definition::Definition;
pub use law::Law;
pub use measurement::Measurement;
pub(crate) use measurement::Measurements;

use crate::statistics::Estimate;
use kinetoscope_manifest::Coordinate;
use serde::Serialize;
use std::collections::BTreeMap;

/// Version of the layout of `metrics.json`.
pub(crate) const SCHEMA: u32 = 1;

/// A value with its definition and scope.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Metric {
    /// The definition.
    pub(crate) definition: &'static Definition,
    /// The value.
    pub(crate) value: f64,
    /// The standard error, if known.
    pub(crate) standard_error: Option<f64>,
    /// The theoretical value, if there is one.
    pub(crate) theory: Option<f64>,
    /// A deviation below this is a rounding error.
    pub(crate) rounding: f64,
    /// How the value is derived, and the law of the theoretical value.
    pub(crate) source: String,
    /// The run or the part of the sweep that the value describes.
    pub(crate) scope: MetricScope,
}

/// Deviation of a value from theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Deviation {
    /// Within rounding errors.
    Rounding,
    /// In standard errors.
    StandardErrors(f64),
    /// The difference, if no standard error is known.
    Bare(f64),
}

/// Deviations below this fraction of the theoretical value are rounding errors.
const ROUNDING_FRACTION: f64 = 1e-9;

impl Metric {
    pub(crate) fn new(
        definition: &'static Definition,
        estimate: Estimate,
        theory: Option<f64>,
        source: String,
        scope: MetricScope,
    ) -> Self {
        let Estimate { value, standard_error } = estimate;
        let rounding = definition.rounding;
        Self { definition, value, standard_error, theory, rounding, source, scope }
    }

    /// The metric's name.
    pub(crate) const fn name(&self) -> &'static str {
        self.definition.name
    }

    /// The metric's unit; empty for the model's own.
    pub(crate) const fn unit(&self) -> &'static str {
        self.definition.unit
    }

    /// The coordinates of the run or of the part of the sweep.
    pub(crate) fn coordinates(&self) -> &[Coordinate] {
        match &self.scope {
            MetricScope::Run(run) => &run.coordinates,
            MetricScope::Sweep(sweep) => &sweep.coordinates,
        }
    }

    /// Deviation from theory; `None` without a theoretical value.
    pub(crate) fn deviation(&self) -> Option<Deviation> {
        let theory = self.theory?;
        let difference = self.value - theory;
        let rounding = self.rounding.max(ROUNDING_FRACTION * theory.abs());
        Some(match self.standard_error {
            _ if difference.abs() <= rounding => Deviation::Rounding,
            // A standard error within rounding is not a measure of the deviation.
            Some(error) if error > rounding => Deviation::StandardErrors(difference / error),
            _ => Deviation::Bare(difference),
        })
    }

    /// Deviation from theory in standard errors, if a standard error is known.
    pub(crate) fn deviation_in_standard_errors(&self) -> Option<f64> {
        match self.deviation() {
            Some(Deviation::StandardErrors(deviation)) => Some(deviation),
            _ => None,
        }
    }
}

/// The run or the part of a sweep that a metric describes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum MetricScope {
    /// One run.
    Run(RunScope),
    /// A point of the sweep, or a fit along one of its axes.
    Sweep(SweepScope),
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct RunScope {
    /// The recording's file name.
    pub(crate) file: String,
    /// The run's coordinates in the sweep.
    #[serde(serialize_with = "as_map")]
    pub(crate) coordinates: Vec<Coordinate>,
    /// Number of the replicate.
    pub(crate) replicate: u32,
    /// How the run ended.
    pub(crate) outcome: String,
}

/// A part of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct SweepScope {
    /// The key along which a fit was made; `None` for the mean over a point's replicates.
    pub(crate) along: Option<String>,
    /// The coordinates that all runs of this part share.
    #[serde(serialize_with = "as_map")]
    pub(crate) coordinates: Vec<Coordinate>,
    /// Number of averaged replicates.
    pub(crate) replicates: usize,
}

fn as_map<S: serde::Serializer>(
    coordinates: &[Coordinate],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let pairs: BTreeMap<&str, &str> = coordinates
        .iter()
        .map(|coordinate| (coordinate.key.as_str(), coordinate.value.as_str()))
        .collect();
    pairs.serialize(serializer)
}
