//! Sentences about checks that no value decides.

use super::missing_runs::first_clause;
use super::number::in_unit;
use super::place::place_words;
use super::{AnswerPart, AnswerSource};
use crate::metric::Metric;
use crate::models::label_of;
use crate::run::RunStatus;
use kinetoscope_manifest::{Check, Coordinate};

/// A check that no run can decide.
pub(super) fn without_value(check: &Check, source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let label = label_of(&check.metric).unwrap_or("quantity of a check");
    let place: Vec<Coordinate> = check
        .at
        .iter()
        .map(|(key, value)| Coordinate { key: key.clone(), value: value.clone() })
        .collect();
    let faults = source.runs.iter().find_map(|run| match &run.ending {
        RunStatus::Fault(what) => Some(format!("a run failed: {}", first_clause(what))),
        RunStatus::Unfinished => Some("a run is not finished".to_owned()),
        _ => None,
    });
    let reason = faults.unwrap_or_else(|| "no finished run has it".to_owned());
    let text = format!(
        "A check fails: the {label}{} has no value, because {reason}.",
        place_words(&place)
    );
    vec![AnswerPart::Failure(text)]
}

/// A metric without a number, which a check compares.
pub(super) fn missing_value(metric: &Metric) -> Vec<AnswerPart> {
    let place = place_words(metric.coordinates());
    let reason = metric.reason().unwrap_or_else(|| "there is no number".to_owned());
    let label = metric.definition.label;
    let text = format!("A check fails: the {label}{place} has no value, because {reason}.");
    vec![AnswerPart::Failure(text)]
}

/// A metric with a number that lacks what a check needs.
pub(super) fn undecided_value(metric: &Metric, reason: &str) -> Vec<AnswerPart> {
    let place = place_words(metric.coordinates());
    let (label, value) = (metric.definition.label, in_unit(metric.value(), metric));
    let text = format!("A check cannot be decided: the {label}{place} is {value}, {reason}.");
    vec![AnswerPart::Failure(text)]
}
