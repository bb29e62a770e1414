//! Metrics of several runs: means over replicates, fits and plots along an axis of a sweep.

pub mod figures;
pub mod fits;

use crate::input::coordinates::grouped;
use crate::metric::{Metric, MetricScope, SweepScope};
use crate::run::RunAnalysis;
use crate::statistics::{mean, mean_of_independent};
use kinetoscope_manifest::Coordinate;

/// The runs at one point of a sweep.
#[derive(Clone, Debug)]
pub struct SweepPoint<'a> {
    /// The point's coordinates.
    pub coordinates: Vec<Coordinate>,
    /// The point's complete replicates.
    pub runs: Vec<&'a RunAnalysis>,
}

/// The points of a sweep with their complete runs, in the order of the runs.
#[must_use]
pub fn points(runs: &[RunAnalysis]) -> Vec<SweepPoint<'_>> {
    let complete = runs.iter().filter(|run| run.is_complete());
    grouped(complete.map(|run| (run.coordinates.clone(), run)))
        .into_iter()
        .map(|(coordinates, runs)| SweepPoint { coordinates, runs })
        .collect()
}

/// Means over replicates, for points with several replicates that all have the metric.
#[must_use]
pub fn replicate_means(points: &[SweepPoint<'_>]) -> Vec<Metric> {
    let mut means = Vec::new();
    for point in points.iter().filter(|point| point.runs.len() > 1) {
        for first in &point.runs[0].measurements {
            let all: Vec<_> =
                point.runs.iter().filter_map(|run| run.measurement(first.name())).collect();
            let values: Vec<f64> = all.iter().map(|found| found.estimate.value).collect();
            let Some(estimate) =
                mean_of_independent(&values).filter(|_| all.len() == point.runs.len())
            else {
                continue;
            };
            let theories: Option<Vec<f64>> = all.iter().map(|found| found.theory).collect();
            means.push(Metric {
                definition: first.definition,
                value: estimate.value,
                standard_error: estimate.standard_error,
                theory: theories.and_then(|theories| mean(&theories)),
                rounding: first.definition.rounding,
                source: format!("mean over replicates of {}", first.source()),
                scope: MetricScope::Sweep(SweepScope {
                    along: None,
                    coordinates: point.coordinates.clone(),
                    replicates: point.runs.len(),
                }),
            });
        }
    }
    means
}
