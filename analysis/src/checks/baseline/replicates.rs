//! What the replicates of a mean state about its error.
//!
//! A mean over R replicates has the error s/sqrt(R) with R - 1 degrees of freedom, s their standard deviation. If each of the replicates
//! has an error e_i that follows from a formula, so that it has no degrees of freedom, the mean has the error sqrt(sum of e_i^2)/R: for four
//! replicates, a comparison finds less than half the change.
//!
//! Such an error is as good as exact, but the value is a sum over N particles, which is normal for many only: Student's t with N degrees of
//! freedom for each value stands for its longer tails. The difference of two chi-squares with k degrees of freedom has the excess kurtosis 6/k, and t
//! with k + 4 degrees of freedom the same: k/2 for each are on the safe side.

use super::kinds::CHI_SQUARES;
use super::relation::Place;
use crate::metric_files::document::{Document, MetricEntry, ScopeEntry};
use std::collections::BTreeMap;

/// The replicates of a mean.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Replicates {
    /// The error of the mean by those of the replicates, if each follows from a formula, with its degrees of freedom.
    pub(super) known_error: Option<(f64, f64)>,
    /// Whether the manifest sets the value of each.
    pub(super) are_set_by_manifest: bool,
    /// Whether the value of one differs from start to start by an amount that the run does not tell.
    pub(super) depend_on_start: bool,
}

/// Degrees of freedom of a value's error: its own, or else those of a sum over this many particles.
pub(super) fn freedom(entry: &MetricEntry, particles: f64) -> f64 {
    let of_formula = || {
        let error = entry.standard_error?;
        let is_chi_square = CHI_SQUARES.contains(&entry.name.as_str());
        let mean = entry.theory_in_range().filter(|_| is_chi_square)?;
        // A mean of squares with k degrees of freedom scatters by sqrt(2/k) of itself: this is k/2.
        Some((mean / error).powi(2))
    };
    let freedom = entry.degrees_of_freedom.or_else(of_formula);
    freedom.filter(|freedom| *freedom > 0.0).unwrap_or(particles)
}

/// The metrics of the runs of an analysis, by name and by the place of their mean.
pub(super) struct MetricsOfRuns<'a> {
    metrics: BTreeMap<(&'a str, Place), Vec<&'a MetricEntry>>,
    /// The number of runs by the place of their mean.
    runs: BTreeMap<Place, usize>,
}

impl<'a> MetricsOfRuns<'a> {
    pub(super) fn of(document: &'a Document) -> Self {
        let mut runs: BTreeMap<_, Vec<_>> = BTreeMap::new();
        let is_run = |entry: &&MetricEntry| matches!(entry.scope, ScopeEntry::Run { .. });
        for entry in document.metrics.iter().filter(is_run) {
            let mean = Place::of_metric(entry).of_mean();
            runs.entry((entry.name.as_str(), mean)).or_default().push(entry);
        }
        let mut counts = BTreeMap::new();
        for run in &document.runs {
            *counts.entry(Place::of_run(run).of_mean()).or_default() += 1;
        }
        Self { metrics: runs, runs: counts }
    }

    /// Whether some of the runs at a place have a value of a metric and others have none, so that the seed decides.
    pub(super) fn is_of_some_runs(&self, name: &str, place: &Place) -> bool {
        let place = place.of_mean();
        let all = self.runs.get(&place).copied().unwrap_or(0);
        let entries = self.metrics.get(&(name, place)).into_iter().flatten();
        let with_value = entries.filter(|entry| entry.value.is_some()).count();
        with_value > 0 && with_value < all
    }

    /// What the replicates of a mean state; nothing of a run, of a fit, or if some replicates are missing.
    pub(super) fn of_mean(
        &self,
        entry: Option<&MetricEntry>,
        place: &Place,
        particles: f64,
    ) -> Replicates {
        let replicates = match entry.map(|entry| &entry.scope) {
            Some(ScopeEntry::Sweep { along: None, replicates, .. }) => *replicates,
            _ => return Replicates::default(),
        };
        let found = entry.and_then(|entry| self.metrics.get(&(entry.name.as_str(), place.clone())));
        let Some(runs) = found.filter(|runs| runs.len() == replicates) else {
            return Replicates::default();
        };
        let square = |run: &&MetricEntry| {
            run.standard_error
                .filter(|_| run.degrees_of_freedom.is_none())
                .map(|error| error * error)
        };
        let squares: Option<Vec<f64>> = runs.iter().map(square).collect();
        let sum = squares.map(|squares| squares.iter().sum::<f64>());
        let freedom = runs.iter().map(|run| freedom(run, particles)).sum();
        Replicates {
            known_error: sum.map(|sum| (sum.sqrt() / replicates as f64, freedom)),
            are_set_by_manifest: runs.iter().all(|run| run.is_set_by_manifest()),
            depend_on_start: runs.iter().any(|run| run.depends_on_start()),
        }
    }
}
