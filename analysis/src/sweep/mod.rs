//! Metrics of several runs: means over replicates, fits and plots along an axis of a sweep.

mod asymptotic_range;
pub(crate) mod figures;
pub(crate) mod fits;
mod reference_lines;
pub(crate) mod requested;
pub(crate) mod samples;
pub(crate) mod swept_key;

use crate::input::coordinates::grouped;
use crate::metric::{Measurement, Metric, MetricScope, SweepScope, Theory};
use crate::run::RunAnalysis;
use crate::statistics::{Estimate, mean, mean_of_independent};
use kinetoscope_manifest::Coordinate;
use std::collections::BTreeSet;

/// The runs at one point of a sweep.
#[derive(Clone, Debug)]
pub(crate) struct SweepPoint<'a> {
    /// The point's coordinates.
    pub(crate) coordinates: Vec<Coordinate>,
    /// The point's complete replicates.
    pub(crate) runs: Vec<&'a RunAnalysis>,
}

impl SweepPoint<'_> {
    /// Mean of a metric over the replicates that have it, with the mean theoretical value if all have one, and the number
    /// of these replicates. A single value keeps its own error.
    pub(crate) fn mean_of(&self, metric: &str) -> Option<(Estimate, Option<Theory>, usize)> {
        let found = self.runs.iter().filter_map(|run| run.measurement(metric));
        let found: Vec<&Measurement> = found.collect();
        if let [single] = found.as_slice() {
            return Some((single.estimate, single.theory, 1));
        }
        let values: Vec<f64> = found.iter().map(|found| found.estimate.value).collect();
        let mut estimate = mean_of_independent(&values)?;
        let theories: Option<Vec<Theory>> = found.iter().map(|found| found.theory).collect();
        let Some(theories) = theories else { return Some((estimate, None, found.len())) };
        let is_conditional = theories.iter().any(|theory| theory.value != theories[0].value);
        if is_conditional {
            // Theory that follows each run's start does not deviate by the scatter of the starts.
            let pairs = values.iter().zip(&theories);
            let deviations: Vec<f64> = pairs.map(|(value, theory)| value - theory.value).collect();
            estimate.conditional_standard_error = mean_of_independent(&deviations)?.standard_error;
        }
        Some((estimate, mean_theory(&theories), found.len()))
    }
}

/// The note on points whose deviations are correlated. It concerns all sweeps alike, so that neither plots nor a brief text show it.
pub(crate) const SHARED_STREAMS: &str = "the points use the same random numbers: their errors may have a common part, which cancels in differences between points";

/// Whether a metric scatters from seed to seed and two points of the sweep have the same seed and replicate: a run's random
/// streams depend on these two only, so that points differ by the swept keys and not by chance.
fn share_random_streams(points: &[SweepPoint<'_>], metric: &str) -> bool {
    let mut streams = BTreeSet::new();
    let mut is_shared = false;
    let mut scatters = false;
    for point in points {
        let own: BTreeSet<(u64, u32)> =
            point.runs.iter().map(|run| (run.manifest.seed, run.manifest.replicate)).collect();
        is_shared |= own.iter().any(|stream| streams.contains(stream));
        streams.extend(own);
        scatters |= point.mean_of(metric).is_some_and(|(estimate, ..)| {
            let errors = [estimate.standard_error, estimate.conditional_standard_error];
            errors.iter().flatten().any(|error| *error > 0.0)
        });
    }
    is_shared && scatters
}

/// The note for a sweep, if the scatter of one of its metrics is correlated.
pub(crate) fn correlation_note(points: &[SweepPoint<'_>]) -> Option<&'static str> {
    let mut measurements = points.first()?.runs.first()?.measurements.iter();
    measurements.any(|found| share_random_streams(points, found.name())).then_some(SHARED_STREAMS)
}

/// The mean of the replicates' theoretical values, which is as accurate as the least accurate of them.
fn mean_theory(theories: &[Theory]) -> Option<Theory> {
    let values: Vec<f64> = theories.iter().map(|theory| theory.value).collect();
    Some(Theory {
        value: mean(&values)?,
        accuracy: theories.iter().map(|theory| theory.accuracy).fold(0.0, f64::max),
        violation: theories.iter().find_map(|theory| theory.violation),
        law: theories[0].law,
    })
}

/// The points of a sweep with their complete runs, in the order of the runs.
pub(crate) fn points(runs: &[RunAnalysis]) -> Vec<SweepPoint<'_>> {
    let complete = runs.iter().filter(|run| run.is_complete());
    grouped(complete.map(|run| (run.coordinates.clone(), run)))
        .into_iter()
        .map(|(coordinates, runs)| SweepPoint { coordinates, runs })
        .collect()
}

/// Means over replicates, for points with several replicates that all have the metric.
pub(crate) fn replicate_means(points: &[SweepPoint<'_>]) -> Vec<Metric> {
    let mut means = Vec::new();
    for point in points.iter().filter(|point| point.runs.len() > 1) {
        for first in &point.runs[0].measurements {
            let found = point.mean_of(first.name());
            let Some((estimate, theory, replicates)) =
                found.filter(|(.., replicates)| *replicates == point.runs.len())
            else {
                continue;
            };
            let coordinates = point.coordinates.clone();
            let scope = MetricScope::Sweep(SweepScope { along: None, coordinates, replicates });
            means.push(Metric::new(first.definition, estimate, theory, scope));
        }
    }
    means
}
