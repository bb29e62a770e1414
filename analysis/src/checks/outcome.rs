//! The outcomes of the runs against the one that the manifest expects.

use super::{CheckKind, CheckResult, one_line};
use crate::input::coordinates;
use crate::metric::Measurement;
use crate::models::never_in;
use crate::run::{RunAnalysis, RunStatus};
use kinetoscope_console::text::plural;
use kinetoscope_manifest::{Check, ExpectedOutcome, ExperimentRecord};
use std::collections::BTreeSet;

/// The finding of a run that was interrupted or is still in progress.
const UNFINISHED: &str =
    "unfinished: the run was interrupted or is in progress; the same command resumes it";

/// The outcomes of the runs of an experiment, and the counts of what never happens in a correct one.
pub(crate) fn all(
    record: Option<&ExperimentRecord>,
    further: &[Check],
    runs: &[RunAnalysis],
    seconds: &[f64],
) -> Vec<CheckResult> {
    let expected = record.map_or(ExpectedOutcome::Complete, |record| record.expected_outcome);
    let stated = record.into_iter().flat_map(|record| &record.checks).chain(further);
    let stated: Vec<&Check> = stated.collect();
    let mut results = evaluate(runs, seconds, expected);
    results.extend(unexpected_counts(runs, &stated));
    results
}

/// Compares the outcome of each run with the expected one. `seconds` are the durations of the runs' analyses. An unfinished run
/// has not completed, so it fails; a damaged one is reported as unreadable.
fn evaluate(runs: &[RunAnalysis], seconds: &[f64], expected: ExpectedOutcome) -> Vec<CheckResult> {
    let results = runs.iter().zip(seconds).filter_map(|(run, &seconds)| {
        let (passed, finding) = match (&run.ending, expected) {
            (RunStatus::Damaged(_), _) => return None,
            (RunStatus::Unfinished, _) => (false, UNFINISHED.to_owned()),
            (RunStatus::Complete, ExpectedOutcome::Complete) => (true, "complete".to_owned()),
            (RunStatus::Complete, ExpectedOutcome::Fault) => {
                (false, "complete, but the manifest expects a fault".to_owned())
            }
            (RunStatus::Fault(fault), ExpectedOutcome::Complete) => {
                (false, format!("failed: {}", one_line(fault)))
            }
            (RunStatus::Fault(fault), ExpectedOutcome::Fault) => {
                (true, format!("failed as expected: {}", one_line(fault)))
            }
        };
        Some(CheckResult {
            passed,
            kind: CheckKind::Outcome,
            subject: run.file.clone(),
            run: Some(name_of(run)),
            requirement: match expected {
                ExpectedOutcome::Complete => "completes".to_owned(),
                ExpectedOutcome::Fault => "fails".to_owned(),
            },
            finding,
            file: None,
            line: 0,
            seconds,
        })
    });
    results.collect()
}

/// The experiment, the point of the sweep and the replicate, which stay the same when a value changes, as the file's name does not.
fn name_of(run: &RunAnalysis) -> String {
    let experiment = run.file.split("__").next().unwrap_or_default();
    let mut name = experiment.trim_end_matches(".mcap").to_owned();
    let place = coordinates::text(&run.coordinates);
    if !place.is_empty() {
        name += &format!(" at {place}");
    }
    match run.manifest.replicate {
        0 => name,
        replicate => format!("{name}, replicate {replicate}"),
    }
}

/// The runs with a count above 0 of what never happens in a correct one, such as particles outside of their container. A check of
/// that metric states that it is expected, or fails itself.
fn unexpected_counts(runs: &[RunAnalysis], checks: &[&Check]) -> Vec<CheckResult> {
    let of_run = |run: &RunAnalysis| {
        let never = never_in(run.model().name());
        let counts = run.measurements.iter().filter(|count| never.contains(&count.definition));
        let found = counts.filter(|count| count.estimate.value > 0.0).filter(|count| {
            !checks.iter().any(|check| {
                check.metric == count.definition.name && check.selects(&run.coordinates)
            })
        });
        let result = |count: &Measurement| CheckResult {
            passed: false,
            kind: CheckKind::Outcome,
            subject: run.file.clone(),
            run: Some(name_of(run)),
            requirement: format!("{} = 0", count.definition.name),
            finding: format!(
                "{} = {}; if that is expected, add a check of it",
                count.definition.name, count.estimate.value
            ),
            file: None,
            line: 0,
            seconds: 0.0,
        };
        found.map(result).collect::<Vec<_>>()
    };
    runs.iter().flat_map(of_run).collect()
}

/// The number of runs that these results are about: a run has one for its end, and one for each count above 0.
pub(crate) fn number_of_runs<'a>(results: impl Iterator<Item = &'a CheckResult>) -> usize {
    let of_runs = results.filter(|result| result.kind == CheckKind::Outcome);
    of_runs.map(|result| &result.subject).collect::<BTreeSet<_>>().len()
}

/// The outcomes that the headline reports: failures, and runs that are unfinished or damaged; `None` if there are none.
pub(crate) fn headline(runs: &[RunAnalysis], results: &[CheckResult]) -> Option<String> {
    let count = |number: usize| format!("{number} of {}", plural(runs.len() as u64, "run"));
    let is_failed = |result: &&CheckResult| {
        result.kind == CheckKind::Outcome && !result.passed && result.finding != UNFINISHED
    };
    let failed: Vec<&CheckResult> = results.iter().filter(is_failed).collect();
    let mut parts = Vec::new();
    if let Some(first) = failed.first() {
        parts.push(format!(
            "{} without the expected outcome: {}",
            count(number_of_runs(failed.iter().copied())),
            first.text()
        ));
    }
    let unfinished = runs.iter().filter(|run| run.ending == RunStatus::Unfinished).count();
    if unfinished > 0 {
        parts.push(format!("{} unfinished", count(unfinished)));
    }
    let damaged = runs.iter().filter(|run| matches!(run.ending, RunStatus::Damaged(_))).count();
    if damaged > 0 {
        parts.push(format!("{} damaged", count(damaged)));
    }
    (!parts.is_empty()).then(|| parts.join("; "))
}
