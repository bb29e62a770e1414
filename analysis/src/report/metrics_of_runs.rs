//! Which metrics of single runs an analysis lists: all of a small experiment, and of a large one those that its results need.

use crate::input::coordinates;
use crate::metric::Metric;
use crate::metric_files::document::MOST_RUNS;
use crate::models::main_results;
use crate::run::RunAnalysis;
use kinetoscope_manifest::{AnswerPart, Check, ExperimentRecord, PlotRequest};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of sweep points in the terminal; the files contain all.
pub(super) const MAX_POINTS_SHOWN: usize = 6;

/// The metrics of the runs. Of more than [`MOST_RUNS`], they are those of the first points, which are shown, and those that checks, the
/// answer and requested plots name at points without a mean over replicates: 25 metrics of each of 20,000 runs would take more memory
/// than everything else.
pub(super) fn metrics_of_runs(
    runs: &[RunAnalysis],
    of_sweep: &[Metric],
    record: Option<&ExperimentRecord>,
    checks: &[Check],
) -> Vec<Metric> {
    if runs.len() <= MOST_RUNS {
        return runs.iter().flat_map(RunAnalysis::metrics).collect();
    }
    let needed = needed_names(runs, record, checks);
    let mut means: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for mean in of_sweep.iter().filter(|metric| !metric.is_fit()) {
        means.entry(coordinates::text(mean.coordinates())).or_default().insert(mean.name());
    }
    let mut shown = BTreeSet::new();
    let mut listed = Vec::new();
    for run in runs {
        let place = coordinates::text(&run.coordinates);
        let of_point = means.get(&place);
        let has_mean = |metric: &Metric| of_point.is_some_and(|it| it.contains(metric.name()));
        let is_shown = shown.contains(&place) || shown.len() < MAX_POINTS_SHOWN;
        let is_listed = |metric: &Metric| {
            is_shown && of_point.is_none() || needed.contains(metric.name()) && !has_mean(metric)
        };
        listed.extend(run.metrics().filter(is_listed));
        if is_shown {
            shown.insert(place);
        }
    }
    listed
}

/// The metrics that checks, the answer, requested plots and the main results of the models name.
fn needed_names(
    runs: &[RunAnalysis],
    record: Option<&ExperimentRecord>,
    checks: &[Check],
) -> BTreeSet<String> {
    let own = record.map_or(&[][..], |record| &record.checks);
    let mut names: BTreeSet<String> =
        own.iter().chain(checks).map(|check| check.metric.clone()).collect();
    let parts = record.and_then(|record| record.answer.as_ref()).map_or(&[][..], |it| it.parts());
    names.extend(parts.iter().filter_map(|part| match part {
        AnswerPart::Metric(reference) => Some(reference.metric.clone()),
        AnswerPart::Text(_) => None,
    }));
    let plots = record.map_or(&[][..], |record| &record.plots);
    names.extend(plots.iter().flat_map(PlotRequest::ordinates).map(str::to_owned));
    for run in runs {
        let main = main_results(run.model()).metrics.iter();
        names.extend(
            main.filter(|name| !names.contains(**name))
                .map(|name| (*name).to_owned())
                .collect::<Vec<_>>(),
        );
    }
    names
}
