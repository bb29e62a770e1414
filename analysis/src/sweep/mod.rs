//! Metrics of several runs: means over replicates, fits and plots along an axis of a sweep.

pub(crate) mod figures;
pub(crate) mod fits;

use crate::input::coordinates::grouped;
use crate::metric::{Measurement, Metric, MetricScope, SweepScope};
use crate::run::RunAnalysis;
use crate::statistics::{Estimate, mean, mean_of_independent};
use kinetoscope_manifest::Coordinate;

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
    fn mean_of(&self, metric: &str) -> Option<(Estimate, Option<f64>, usize)> {
        let found = self.runs.iter().filter_map(|run| run.measurement(metric));
        let found: Vec<&Measurement> = found.collect();
        if let [single] = found.as_slice() {
            return Some((single.estimate, single.theory, 1));
        }
        let values: Vec<f64> = found.iter().map(|found| found.estimate.value).collect();
        let theories: Option<Vec<f64>> = found.iter().map(|found| found.theory).collect();
        let theory = theories.and_then(|theories| mean(&theories));
        Some((mean_of_independent(&values)?, theory, found.len()))
    }
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
            let source = format!("mean over replicates of {}", first.source());
            means.push(Metric::new(first.definition, estimate, theory, source, scope));
        }
    }
    means
}
