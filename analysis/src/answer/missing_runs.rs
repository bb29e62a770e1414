//! Runs that an answer does not follow from: those that failed, are not finished, or are not among the recordings.

use super::{AnswerPart, AnswerSource};
use crate::number_text::with_short_numbers;
use crate::run::{RunAnalysis, RunStatus};
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::ExpectedOutcome;

/// Whether a run ended as the manifest expects.
pub(super) fn is_whole(run: &RunAnalysis, source: &AnswerSource<'_>) -> bool {
    let expected = source.record.map(|record| record.expected_outcome);
    match &run.ending {
        RunStatus::Complete => true,
        RunStatus::Fault(_) => expected == Some(ExpectedOutcome::Fault),
        RunStatus::Unfinished | RunStatus::Damaged(_) => false,
    }
}

/// From how many of the planned runs the answer follows, if more are missing than the number of those that it states to have failed;
/// nothing if no run is whole.
pub(super) fn missing_runs(source: &AnswerSource<'_>, stated: usize) -> Option<AnswerPart> {
    let planned = source.record?.runs.len();
    let whole = source.runs.iter().filter(|run| is_whole(run, source)).count();
    let is_partial = whole > 0 && whole + stated < planned;
    is_partial.then(|| AnswerPart::words(format!(" This is from {whole} of {planned} runs.")))
}

/// The first clause of a text about a failure, with short numbers: the advice that follows is for the terminal, and the notes have the
/// whole text.
pub(super) fn first_clause(what: &str) -> String {
    let line = one_line(what);
    let first = line.split(". ").next().unwrap_or_default();
    let first = first.split("; ").next().unwrap_or_default();
    with_short_numbers(first.trim_end_matches('.'))
}
