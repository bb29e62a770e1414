//! Sentences that follow from the checks and the requested plots, for a manifest without an answer of its own, and for checks that fail.

use super::dependence::dependence;
use super::missing_runs::{first_clause, is_whole, missing_runs};
use super::number::{form_of, metric_text, unit_words};
use super::place::{key_words, place_words};
use super::question::shared_words;
use super::relation::{relation, requirement, to_theory};
use super::{AnswerNumber, AnswerPart, AnswerSource};
use crate::checks::{checked_metrics, compare};
use crate::input::coordinates::text;
use crate::metric::{Deviation, Metric, MetricScope};
use crate::models::{label_of, main_results};
use crate::number_text::{plus_minus, significant};
use crate::run::{RunAnalysis, RunStatus};
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::{
    Bound, Check, Coordinate, ExpectedOutcome, IfUndecided, TimingComparison, unit_of_key,
};
use std::cmp::Reverse;
use std::collections::BTreeSet;

/// Maximum number of sentences.
const MOST_SENTENCES: usize = 2;

/// The failed checks, each in a sentence with its reason.
pub(super) fn failures(source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let mut failures: Vec<_> = failed_runs(source).into_iter().collect();
    for check in source.checks {
        let checked = checked_metrics(check, source.metrics);
        if checked.is_empty() {
            failures.push(without_value(check, source));
        }
        let all = checked.len();
        let failed = checked.into_iter().filter(|metric| !compare(check, metric).passed);
        let (failed, missing): (Vec<_>, Vec<_>) = failed.partition(|it| it.is_applicable());
        failures.extend(missing.into_iter().map(missing_value));
        failures.extend((!failed.is_empty()).then(|| failure(check, &failed, all)));
    }
    let more = failures.len().saturating_sub(MOST_SENTENCES);
    failures.truncate(MOST_SENTENCES);
    let mut parts = joined(failures);
    if more > 0 {
        parts.push(AnswerPart::words(format!(" {more} further checks fail.")));
    }
    parts
}

/// How many runs failed, and why the first one did; `None` with a sentence of the manifest, in which the values of these runs are missing.
fn failed_runs(source: &AnswerSource<'_>) -> Option<Vec<AnswerPart>> {
    let record = source.record.filter(|record| record.answer.is_none())?;
    let faults = source.runs.iter().filter_map(|run| match &run.ending {
        RunStatus::Fault(what) => Some(what),
        _ => None,
    });
    let first = first_clause(faults.clone().next()?);
    let (failed, all) = (faults.count(), record.runs.len());
    let count = if all == 1 { "The run".to_owned() } else { format!("{failed} of {all} runs") };
    Some(vec![match record.expected_outcome {
        ExpectedOutcome::Complete => AnswerPart::Failure(format!("{count} failed: {first}.")),
        ExpectedOutcome::Fault => {
            AnswerPart::words(format!("{count} failed, as expected: {first}."))
        }
    }])
}

/// From how many of the planned runs the sentences follow, after those about failed runs.
pub(super) fn remark_on_missing_runs(source: &AnswerSource<'_>) -> Option<AnswerPart> {
    let failed =
        |run: &&RunAnalysis| matches!(run.ending, RunStatus::Fault(_)) && !is_whole(run, source);
    missing_runs(source, source.runs.iter().filter(failed).count())
}

/// The ratio of run times, if it was measured.
pub(super) fn timing(source: &AnswerSource<'_>) -> Option<String> {
    let TimingComparison { of, over, all, .. } = source.timing?.comparison.as_ref()?;
    let ratio = plus_minus(all.mean, all.standard_error);
    let ratio = ratio.unwrap_or_else(|| significant(all.mean, 3));
    Some(format!(
        "The runs of {} take {ratio} times as long as those of {}.",
        one_line(of),
        one_line(over)
    ))
}

/// A check that no run can decide.
fn without_value(check: &Check, source: &AnswerSource<'_>) -> Vec<AnswerPart> {
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
fn missing_value(metric: &Metric) -> Vec<AnswerPart> {
    let place = place_words(metric.coordinates());
    let reason = metric.reason().unwrap_or_else(|| "there is no number".to_owned());
    let label = metric.definition.label;
    let text = format!("A check fails: the {label}{place} has no value, because {reason}.");
    vec![AnswerPart::Failure(text)]
}

/// The values that violate a check, out of `all` that it compares.
fn failure(check: &Check, failed: &[&Metric], all: usize) -> Vec<AnswerPart> {
    let count = failed.len();
    let points = match (count, all) {
        (1, _) => String::new(),
        (_, _) if count < all => format!(" at {count} of {all} points of the sweep"),
        _ => everywhere(all),
    };
    let worst = failed.iter().copied().max_by(|one, other| {
        let excess = |metric: &Metric| metric.theory_value().map_or(0.0, |it| metric.value() - it);
        excess(one).abs().total_cmp(&excess(other).abs())
    });
    let label = failed.first().map_or("", |metric| metric.definition.label);
    let mut parts = vec![
        AnswerPart::Failure(format!("A check fails{points}: ")),
        AnswerPart::words(format!("the {label}")),
    ];
    if let [metric] = failed {
        parts.push(AnswerPart::words(place_words(metric.coordinates())));
    }
    parts.push(AnswerPart::words(" is "));
    let requirement = worst.map_or_else(String::new, |metric| requirement(check, metric));
    match failed {
        [metric] => parts.push(number(metric, Some(false))),
        several => parts.extend(listed(several, Some(false))),
    }
    parts.push(AnswerPart::words(format!("{requirement}.")));
    for part in &mut parts {
        if let AnswerPart::Number(number) = part {
            number.is_failure_stated = true;
        }
    }
    parts
}

/// What the requested plots show, then what the checks found, those of conservation laws last. Without a requested plot, and if no check is of a main
/// result of what the manifest sets, the main results follow, so that every experiment has an answer.
pub(super) fn findings(source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let plots = source.record.map_or(&[][..], |record| &record.plots);
    let shown = plots.iter().filter(|plot| !plot.is_of_channel()).map(|plot| Check {
        metric: plot.y.clone(),
        at: plot.at.clone(),
        bound: Bound::Range { minimum: None, maximum: None },
        if_undecided: IfUndecided::Pass,
        line: 0,
    });
    let shown =
        shown.map(|plot| (None, plot.at.is_empty(), checked_metrics(&plot, source.metrics)));
    let checked =
        source.checks.iter().copied().map(|check| {
            (Some(check), check.at.is_empty(), checked_metrics(check, source.metrics))
        });
    let (mut findings, mut is_shown): (Vec<Finding<'_>>, bool) = (Vec::new(), false);
    for (check, is_everywhere, metrics) in shown.chain(checked).filter(|it| !it.2.is_empty()) {
        match findings.iter_mut().find(|it| it.name() == metrics[0].name()) {
            Some(known) => known.add(check, &metrics),
            None => {
                is_shown |= check.is_none();
                findings.push(Finding { check, is_everywhere, has_places: false, metrics });
            }
        }
    }
    findings.retain(|finding| finding.metrics.iter().all(|metric| metric.is_applicable()));
    let main = main_findings(source);
    let is_main = |finding: &Finding<'_>| main.iter().any(|it| it.name() == finding.name());
    let is_answered = is_shown || findings.iter().any(is_main);
    if !is_answered || findings.iter().all(Finding::is_of_conservation_law) {
        findings.extend(main);
        // Checks come first, unless the question has words of a main result only.
        findings.sort_by_key(|finding| Reverse(shared_words(source, finding.name())));
    }
    findings.sort_by_key(Finding::is_of_conservation_law);
    let shown = findings.iter().take(MOST_SENTENCES);
    let sentences = shown.map(|finding| finding.sentences(source)).collect::<Vec<_>>();
    if sentences.is_empty() { unfinished(source) } else { joined(sentences) }
}

/// The main metrics of what the manifests set, as far as every run has them.
fn main_findings<'a>(source: &AnswerSource<'a>) -> Vec<Finding<'a>> {
    let mut names: Vec<&'static str> = Vec::new();
    for name in source.runs.iter().flat_map(|run| main_results(run.model()).metrics) {
        if !names.contains(name) {
            names.push(name);
        }
    }
    let finding = |name: &&'static str| {
        let everywhere = Check {
            metric: (*name).to_owned(),
            at: Vec::new(),
            bound: Bound::Range { minimum: None, maximum: None },
            if_undecided: IfUndecided::Pass,
            line: 0,
        };
        let metrics = checked_metrics(&everywhere, source.metrics);
        let is_known = !metrics.is_empty() && metrics.iter().all(|metric| metric.is_applicable());
        is_known.then_some(Finding { check: None, is_everywhere: true, has_places: false, metrics })
    };
    let mut findings: Vec<Finding<'_>> = names.iter().filter_map(finding).collect();
    findings.sort_by_key(|finding| Reverse(shared_words(source, finding.name())));
    findings
}

/// What the main metrics of the model show, in a sentence after failed checks of others.
pub(super) fn main_sentence(source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let is_checked =
        |finding: &Finding<'_>| source.checks.iter().any(|check| check.metric == finding.name());
    let findings = main_findings(source);
    let first = findings.iter().find(|finding| !is_checked(finding));
    first.map_or_else(Vec::new, Finding::sentence)
}

/// What is known of one metric.
struct Finding<'a> {
    /// The first check of it; `None` for a plot.
    check: Option<&'a Check>,
    /// Whether the values are those of all points that have one.
    is_everywhere: bool,
    /// Whether several checks select points of their own.
    has_places: bool,
    /// Its values, without duplicates.
    metrics: Vec<&'a Metric>,
}

/// Maximum number of values that a sentence lists with their places.
const MOST_LISTED: usize = 4;

impl<'a> Finding<'a> {
    fn add(&mut self, check: Option<&'a Check>, metrics: &[&'a Metric]) {
        let is_known = |metric: &&Metric| self.metrics.iter().any(|it| std::ptr::eq(*it, *metric));
        let new: Vec<&Metric> = metrics.iter().copied().filter(|it| !is_known(it)).collect();
        self.has_places |= !new.is_empty();
        self.metrics.extend(new);
        self.check = self.check.or(check);
    }

    fn name(&self) -> &'static str {
        self.metrics[0].name()
    }

    fn is_of_conservation_law(&self) -> bool {
        self.metrics.iter().any(|metric| metric.is_of_conservation_law())
    }

    /// The sentence, and how many points of the sweep have no value.
    fn sentences(&self, source: &AnswerSource<'_>) -> Vec<AnswerPart> {
        let whole = source.runs.iter().filter(|run| is_whole(run, source));
        let points = whole.map(|run| text(&run.coordinates)).collect::<BTreeSet<_>>().len();
        let is_fit = |metric: &&&Metric| matches!(&metric.scope, MetricScope::Sweep(scope) if scope.along.is_some());
        let is_of_points = self.is_everywhere && !self.metrics.iter().any(|it| is_fit(&it));
        let missing = points.saturating_sub(self.metrics.len());
        let mut parts = self.sentence();
        if missing > 0 && is_of_points {
            let has = if missing == 1 { "has" } else { "have" };
            parts.push(AnswerPart::words(format!(" {missing} of {points} points {has} no value.")));
        }
        parts
    }

    fn sentence(&self) -> Vec<AnswerPart> {
        match self.metrics.as_slice() {
            [metric] => single(self.check, metric),
            metrics => several(self.check, metrics, self.has_places),
        }
    }
}

/// Why there is nothing to state.
fn unfinished(source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let ending = source.runs.iter().find_map(|run| match &run.ending {
        RunStatus::Fault(what) => {
            Some(format!("No answer: the run failed, {}.", first_clause(what)))
        }
        RunStatus::Unfinished => Some("No answer yet: the run is not finished.".to_owned()),
        _ => None,
    });
    let is_any_complete = source.runs.iter().any(|run| run.is_complete());
    ending.filter(|_| !is_any_complete).map(AnswerPart::Failure).into_iter().collect()
}

fn single(check: Option<&Check>, metric: &Metric) -> Vec<AnswerPart> {
    let place = place_words(metric.coordinates());
    let is_passed = check.map(|_| true);
    if let Some(conserved) = conserved(metric) {
        return vec![
            AnswerPart::words(format!("The {conserved}{place} is conserved to ")),
            AnswerPart::Number(AnswerNumber {
                text: size_text(metric),
                ..answer_number(metric, is_passed)
            }),
            AnswerPart::words("."),
        ];
    }
    let relation = check.map_or_else(|| to_theory(metric), |check| relation(check, metric));
    vec![
        AnswerPart::words(format!("The {}{place} is ", metric.definition.label)),
        number(metric, is_passed),
        AnswerPart::words(format!("{relation}.")),
    ]
}

/// The fraction above which a violated quantity is not called conserved.
const LARGEST_VIOLATION: f64 = 0.1;

/// The quantity that is conserved, unless its violation is exactly 0, or large.
fn conserved(metric: &Metric) -> Option<&'static str> {
    let law = metric.theory.filter(|theory| theory.in_range())?.law?;
    let size = metric.value().abs();
    law.conserved.filter(|_| size > 0.0 && size <= LARGEST_VIOLATION)
}

fn size_text(metric: &Metric) -> String {
    format!("{}{}", significant(metric.value().abs(), 2), unit_words(metric.unit()))
}

/// The values of several points with their places, or the least and the greatest of many, and how far from theory they are at most.
fn several(check: Option<&Check>, metrics: &[&Metric], has_places: bool) -> Vec<AnswerPart> {
    let by_value = |one: &&&Metric, other: &&&Metric| one.value().total_cmp(&other.value());
    let extremes = metrics.iter().min_by(by_value).zip(metrics.iter().max_by(by_value));
    let Some((least, greatest)) = extremes else { return Vec::new() };
    let is_passed = check.map(|_| true);
    let everywhere = everywhere(metrics.len());
    let size = |metric: &Metric| metric.value().abs();
    let worst = if size(least) > size(greatest) { least } else { greatest };
    if let Some(conserved) = conserved(worst).filter(|_| !has_places) {
        return vec![
            AnswerPart::words(format!("The {conserved} is conserved to ")),
            AnswerPart::Number(AnswerNumber {
                text: size_text(worst),
                ..answer_number(worst, is_passed)
            }),
            AnswerPart::words(format!("{everywhere}.")),
        ];
    }
    let start = AnswerPart::words(format!("The {} is ", least.definition.label));
    let relation = if has_places { String::new() } else { common_relation(metrics) };
    let text = |metric: &Metric| metric_text(metric, form_of(metric));
    if text(least) == text(greatest) && !has_places {
        let end = AnswerPart::words(format!("{everywhere}{relation}."));
        return vec![start, number(least, is_passed), end];
    }
    let key = |coordinate: &Coordinate| {
        let unit = unit_of_key(&coordinate.key);
        let words = key_words(&coordinate.key, unit);
        if unit == "1" && words.ends_with('s') { format!("number of {words}") } else { words }
    };
    let dependence = if has_places { String::new() } else { dependence(metrics, key) };
    let mut parts = vec![start];
    parts.extend(listed(metrics, is_passed));
    parts.push(AnswerPart::words(format!("{dependence}{relation}.")));
    parts
}

fn everywhere(points: usize) -> String {
    match points {
        2 => " at both points of the sweep".to_owned(),
        all => format!(" at all {all} points of the sweep"),
    }
}

/// Values with their places, or the least and the greatest of many.
fn listed(metrics: &[&Metric], is_passed: Option<bool>) -> Vec<AnswerPart> {
    let mut parts = Vec::new();
    let by_value = |one: &&&Metric, other: &&&Metric| one.value().total_cmp(&other.value());
    let extremes = metrics.iter().min_by(by_value).zip(metrics.iter().max_by(by_value));
    if metrics.len() <= MOST_LISTED {
        for (index, metric) in metrics.iter().enumerate() {
            let separator = match metrics.len() - index {
                1 => "",
                2 => " and ",
                _ => ", ",
            };
            parts.push(number(metric, is_passed));
            parts.push(AnswerPart::words(place_words(metric.coordinates()) + separator));
        }
    } else if let Some((least, greatest)) = extremes {
        let to = format!("{} to ", place_words(least.coordinates()));
        let end = place_words(greatest.coordinates());
        parts.extend([
            AnswerPart::words("from "),
            number(least, is_passed),
            AnswerPart::words(to),
            number(greatest, is_passed),
            AnswerPart::words(end),
        ]);
    }
    parts
}

/// Standard errors above which values are not called close to theory.
const LARGEST_AGREEMENT: f64 = 4.0;

/// How far from theory several points are at most.
fn common_relation(metrics: &[&Metric]) -> String {
    let law = common_law(metrics);
    let violation = |metric: &&Metric| metric.theory?.violation;
    if let Some(violation) = metrics.iter().find_map(violation) {
        let law = if law == THEORY { "its law" } else { law };
        return format!(", outside the range of {law}: {violation}");
    }
    let sigma = |metric: &&Metric| match metric.deviation() {
        Some(Deviation::StandardErrors(sigma)) => Some(sigma.abs()),
        Some(Deviation::Rounding) => Some(0.0),
        _ => None,
    };
    let sigmas: Option<Vec<f64>> = metrics.iter().map(sigma).collect();
    match sigmas.and_then(|all| all.into_iter().reduce(f64::max)) {
        Some(0.0) => return format!(", equal to {law}"),
        Some(worst) if worst <= 1.0 => return format!(", within one standard error of {law}"),
        Some(worst) if worst <= LARGEST_AGREEMENT => {
            return format!(", within {} standard errors of {law}", significant(worst, 2));
        }
        Some(worst) => {
            return format!(", up to {} standard errors from {law}", significant(worst, 2));
        }
        None => {}
    }
    let is_inside =
        |metric: &&Metric| matches!(metric.deviation(), Some(Deviation::Bound { is_inside: true }));
    let all_inside = metrics.iter().all(is_inside);
    let law = if law == THEORY { "the law" } else { law };
    if all_inside { format!(", inside the accuracy of {law}") } else { String::new() }
}

/// What a law without a name is called.
const THEORY: &str = "theory";

/// The name of the law of all metrics.
fn common_law(metrics: &[&Metric]) -> &'static str {
    let name = |metric: &&Metric| metric.theory.and_then(|theory| theory.law?.name);
    let first = metrics.first().and_then(name);
    first.filter(|_| metrics.iter().all(|metric| name(metric) == first)).unwrap_or(THEORY)
}

fn number(metric: &Metric, is_passed: Option<bool>) -> AnswerPart {
    AnswerPart::Number(answer_number(metric, is_passed))
}

fn answer_number(metric: &Metric, is_passed: Option<bool>) -> AnswerNumber {
    let text = metric_text(metric, form_of(metric));
    AnswerNumber { metric: metric.name(), text, is_passed, is_failure_stated: false }
}

/// Sentences with spaces between them.
fn joined(sentences: Vec<Vec<AnswerPart>>) -> Vec<AnswerPart> {
    let mut parts = Vec::new();
    for sentence in sentences {
        if !parts.is_empty() {
            parts.push(AnswerPart::words(" "));
        }
        parts.extend(sentence);
    }
    parts
}
