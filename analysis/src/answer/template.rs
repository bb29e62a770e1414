//! The answer that the manifest gives, with its numbers filled in.

use super::missing_runs::{first_clause, is_whole, missing_runs};
use super::number::{
    NumberForm, metric_text, number_with, stated_tolerance, text_of, theory_digits, unit_words,
};
use super::relation::states_value;
use super::{AnswerNumber, AnswerPart, AnswerSource};
use crate::input::coordinates;
use crate::metric::{Metric, MetricScope};
use crate::models::{fitted_along, metrics_of};
use crate::number_text::six_digits;
use crate::run::{RunAnalysis, RunStatus};
use crate::sweep::fits::Refusal;
use kinetoscope_manifest::{AnswerPart as TemplatePart, AnswerTemplate, MetricReference};
use std::collections::BTreeSet;

/// The words and numbers of a template.
pub(super) fn parts(template: &AnswerTemplate, source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let all = template.parts();
    let next = all.iter().skip(1).map(Some).chain([None]);
    let (mut parts, mut has_remark) = (Vec::new(), false);
    // The unit that a number before has, so that it is before the mark of its check and not repeated.
    let mut given = String::new();
    for (part, next) in all.iter().zip(next) {
        match part {
            TemplatePart::Text(text) => {
                let rest = text.strip_prefix(&std::mem::take(&mut given)).unwrap_or(text);
                parts.push(AnswerPart::words(rest));
            }
            TemplatePart::Metric(reference) => match find(reference, source) {
                Ok((metric, note)) => {
                    let unit = unit_words(metric.unit());
                    let is_of_unit =
                        matches!(next, Some(TemplatePart::Text(text)) if names_unit(text, &unit));
                    parts.push(number(reference, metric, is_of_unit, source));
                    if is_of_unit && !reference.is_theory {
                        given = unit;
                    }
                    has_remark |= note.is_some();
                    parts.extend(note.map(AnswerPart::Text));
                }
                Err(reason) => parts.push(AnswerPart::Missing(reason)),
            },
        }
    }
    // A remark on a number states it already.
    parts.extend(missing_runs(source, 0).filter(|_| !has_remark));
    parts
}

/// The number of a reference, in its form. Of theory, it has no unit if the words after it name the unit.
fn number(
    reference: &MetricReference,
    metric: &Metric,
    is_of_unit: bool,
    source: &AnswerSource<'_>,
) -> AnswerPart {
    let form = NumberForm {
        is_size: reference.is_size,
        is_in_percent: reference.is_in_percent,
        digits: reference.digits,
        is_without_unit: is_of_unit && reference.is_theory,
    };
    if !reference.is_theory {
        let (text, is_passed) = (metric_text(metric, form), source.is_passed(metric));
        let mut tolerances =
            source.checks_of(metric).filter_map(|check| stated_tolerance(check, metric));
        let tolerance = tolerances.next();
        let is_compared = source.checks_of(metric).any(states_value);
        let number = number_with(metric, text, is_passed);
        return AnswerPart::Number(AnswerNumber { is_compared, tolerance, ..number });
    }
    match metric.theory.filter(|theory| theory.in_range()) {
        Some(theory) => {
            let digits = form.digits.or_else(|| theory_digits(theory.value, metric));
            let form = NumberForm { digits, ..form };
            AnswerPart::words(text_of(theory.value, None, metric.unit(), form))
        }
        None => {
            let reason = metric.theory.and_then(|theory| theory.out_of_range());
            AnswerPart::Missing(reason.unwrap_or_else(|| "no law applies".to_owned()))
        }
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
    match found.as_slice() {
        [metric] if metric.is_applicable() => Ok((metric, remark(metric, reference, source))),
        [metric] => Err(metric.reason().unwrap_or_default()),
        [] => Err(absent(reference, source)),
        several => Err(match several.iter().find(|metric| !metric.is_applicable()) {
            Some(metric) => metric.reason().unwrap_or_default(),
            None => format!("{} runs have it, which have no mean", several.len()),
        }),
    }
}

/// Whether a metric is of a run that ended as the manifest expects.
fn is_of_whole_run(metric: &Metric, source: &AnswerSource<'_>) -> bool {
    let MetricScope::Run(scope) = &metric.scope else { return true };
    source.runs.iter().any(|run| run.file == scope.file && is_whole(run, source))
}

/// States that a value is not the mean over all replicates, or a fit through all points.
fn remark(
    metric: &Metric,
    reference: &MetricReference,
    source: &AnswerSource<'_>,
) -> Option<String> {
    let selected = |run: &&RunAnalysis| reference.selects(&run.coordinates);
    let runs = match &metric.scope {
        MetricScope::Sweep(scope) if scope.along.is_none() => scope.replicates,
        MetricScope::Sweep(scope) => {
            let complete = source.runs.iter().filter(selected).filter(|run| run.is_complete());
            let place = |run: &RunAnalysis| coordinates::text(&run.coordinates);
            scope.replicates * complete.map(place).collect::<BTreeSet<_>>().len()
        }
        MetricScope::Run(_) => 1,
    };
    let planned = &source.record?.runs;
    let planned = planned.iter().filter(|run| reference.selects(&run.coordinates)).count();
    (runs < planned).then(|| format!(" (from {runs} of {planned} runs)"))
}

/// Why no run has the metric.
fn absent(reference: &MetricReference, source: &AnswerSource<'_>) -> String {
    let here = source.runs.iter().filter(|run| reference.selects(&run.coordinates));
    let here: Vec<&RunAnalysis> = here.collect();
    let metric = reference.metric.as_str();
    let is_refused = |refusal: &&Refusal| {
        refusal.names.contains(&metric) && reference.selects(&refusal.coordinates)
    };
    if let Some(refusal) = source.refusals.iter().find(is_refused) {
        return first_clause(&refusal.why);
    }
    let time = |run: &RunAnalysis| {
        format!("{} {}", six_digits(run.end_time), run.time_unit).trim_end().to_owned()
    };
    let reason = here.iter().find_map(|run| match &run.ending {
        RunStatus::Fault(what) => {
            Some(format!("the run failed at {}: {}", time(run), first_clause(what)))
        }
        RunStatus::Unfinished => Some("the run is not finished".to_owned()),
        RunStatus::Damaged(_) => Some("the recording is damaged".to_owned()),
        RunStatus::Complete => None,
    });
    let Some(run) = here.first() else {
        return "the run is not among the recordings".to_owned();
    };
    let reason = reason.or_else(|| without_channel(metric, run));
    reason.unwrap_or_else(|| match fitted_along(metric).is_empty() {
        true => "the recordings do not give it".to_owned(),
        false => "a fit needs two points of the sweep at least".to_owned(),
    })
}

/// The channel from which the metric follows, if it is not recorded.
fn without_channel(metric: &str, run: &RunAnalysis) -> Option<String> {
    let metrics = metrics_of(run.model().name());
    let how = metrics.iter().find(|known| known.name == metric)?.how;
    let channel =
        how.strip_prefix('/')?.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
    let recorded = run.manifest.record.channels.as_ref()?;
    let is_missing = !recorded.iter().any(|recorded| recorded == channel);
    is_missing.then(|| format!("the channel /{channel} is not recorded"))
}
