//! The answer that the manifest gives, with its numbers filled in.

use super::number::{NumberForm, metric_text, text_of, unit_words};
use super::{AnswerNumber, AnswerPart, AnswerSource};
use crate::metric::{Metric, MetricScope};
use crate::number_text::six_digits;
use crate::run::{RunAnalysis, RunStatus};
use kinetoscope_manifest::{
    AnswerPart as TemplatePart, AnswerTemplate, ExpectedOutcome, MetricReference,
};

/// The words and numbers of a template.
pub(super) fn parts(template: &AnswerTemplate, source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let all = template.parts();
    let next = all.iter().skip(1).map(Some).chain([None]);
    let mut parts = Vec::new();
    for (part, next) in all.iter().zip(next) {
        match part {
            TemplatePart::Text(text) => parts.push(AnswerPart::words(text.as_str())),
            TemplatePart::Metric(reference) => match find(reference, source) {
                Ok((metric, note)) => {
                    parts.push(number(reference, metric, next, source));
                    parts.extend(note.map(AnswerPart::Text));
                }
                Err(reason) => parts.push(AnswerPart::Missing(reason)),
            },
        }
    }
    parts
}

/// The number of a reference, in its form. `next` is the part after it.
fn number(
    reference: &MetricReference,
    metric: &Metric,
    next: Option<&TemplatePart>,
    source: &AnswerSource<'_>,
) -> AnswerPart {
    let unit = unit_words(metric.unit());
    let is_named = matches!(next, Some(TemplatePart::Text(text)) if names_unit(text, &unit));
    let form = NumberForm {
        is_size: reference.is_size,
        is_in_percent: reference.is_in_percent,
        digits: reference.digits,
        is_without_unit: is_named,
    };
    if !reference.is_theory {
        let (text, is_passed) = (metric_text(metric, form), source.is_passed(metric));
        let (metric, is_failure_stated) = (metric.name(), false);
        return AnswerPart::Number(AnswerNumber { metric, text, is_passed, is_failure_stated });
    }
    match metric.theory.filter(|theory| theory.in_range()) {
        Some(theory) => AnswerPart::words(text_of(theory.value, None, metric.unit(), form)),
        None => AnswerPart::Missing("no law applies".to_owned()),
    }
}

/// Whether a text begins with a unit, so that the unit is not repeated.
fn names_unit(text: &str, unit: &str) -> bool {
    let rest = text.strip_prefix(unit).filter(|_| !unit.is_empty());
    rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
}

/// The metric to which a reference leads, with a remark if it is not of all runs.
///
/// # Errors
/// Why there is no value.
fn find<'a>(
    reference: &MetricReference,
    source: &AnswerSource<'a>,
) -> Result<(&'a Metric, Option<String>), String> {
    let named = source.metrics.iter().filter(|metric| metric.name() == reference.metric);
    let here: Vec<&Metric> =
        named.filter(|metric| reference.selects(metric.coordinates())).collect();
    let of_sweep = |metric: &&&Metric| matches!(metric.scope, MetricScope::Sweep(_));
    let found: Vec<&Metric> = if here.iter().any(|metric| of_sweep(&metric)) {
        here.iter().filter(of_sweep).copied().collect()
    } else {
        here.into_iter().filter(|metric| is_of_whole_run(metric, source)).collect()
    };
    let planned = source.record.map_or(0, |record| {
        record.runs.iter().filter(|run| reference.selects(&run.coordinates)).count()
    });
    match found.as_slice() {
        [metric] if metric.is_applicable() => Ok((metric, remark(metric, planned))),
        [metric] => Err(metric.reason().unwrap_or_default()),
        [] => Err(absent(reference, source)),
        several => Err(format!("{} runs have it, which have no mean", several.len())),
    }
}

/// Whether a metric is of a run that ended as the manifest expects.
fn is_of_whole_run(metric: &Metric, source: &AnswerSource<'_>) -> bool {
    let MetricScope::Run(run) = &metric.scope else { return true };
    let expected = source.record.map(|record| record.expected_outcome);
    match run.outcome {
        "complete" => true,
        "fault" => expected == Some(ExpectedOutcome::Fault),
        _ => false,
    }
}

/// States that a value is not the mean over all replicates.
fn remark(metric: &Metric, planned: usize) -> Option<String> {
    let averaged = match &metric.scope {
        MetricScope::Sweep(scope) if scope.along.is_none() => scope.replicates,
        MetricScope::Sweep(_) => return None,
        MetricScope::Run(_) => 1,
    };
    (averaged < planned).then(|| format!(" (from {averaged} of {planned} runs)"))
}

/// Why no run has the metric.
fn absent(reference: &MetricReference, source: &AnswerSource<'_>) -> String {
    let here = source.runs.iter().filter(|run| reference.selects(&run.coordinates));
    let here: Vec<&RunAnalysis> = here.collect();
    let time = |run: &RunAnalysis| {
        format!("{} {}", six_digits(run.end_time), run.time_unit).trim_end().to_owned()
    };
    let reason = here.iter().find_map(|run| match &run.ending {
        RunStatus::Fault(what) => Some(format!("the run failed at {}: {what}", time(run))),
        RunStatus::Unfinished => Some("the run is not finished".to_owned()),
        RunStatus::Damaged(_) => Some("the recording is damaged".to_owned()),
        RunStatus::Complete => None,
    });
    let is_recorded = !here.is_empty();
    reason.unwrap_or_else(|| match is_recorded {
        true => "the recordings do not give it".to_owned(),
        false => "the run is not among the recordings".to_owned(),
    })
}
