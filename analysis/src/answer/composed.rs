//! Sentences that follow from the checks and the requested plots, for a manifest without an answer of its own, and for checks that fail.

use super::number::{NumberForm, metric_text, unit_words};
use super::relation::{relation, requirement, to_theory};
use super::{AnswerNumber, AnswerPart, AnswerSource};
use crate::checks::{checked_metrics, compare};
use crate::input::coordinates::{VARIANT, last_part, shown_value};
use crate::metric::{Deviation, Metric};
use crate::models::label_of;
use crate::number_text::{plus_minus, significant};
use crate::run::RunStatus;
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::{Bound, Check, Coordinate, IfUndecided, TimingComparison, unit_of_key};

/// Maximum number of sentences.
const MOST_SENTENCES: usize = 2;

/// The failed checks, each in a sentence with its reason.
pub(super) fn failures(source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let mut failures = Vec::new();
    for check in source.checks {
        let checked = checked_metrics(check, source.metrics);
        if checked.is_empty() {
            failures.push(without_value(check, source));
        }
        let failed = checked.into_iter().filter(|metric| !compare(check, metric).passed);
        failures.extend(failed.map(|metric| failure(check, metric)));
    }
    let more = failures.len().saturating_sub(MOST_SENTENCES);
    failures.truncate(MOST_SENTENCES);
    let mut parts = joined(failures);
    if more > 0 {
        parts.push(AnswerPart::words(format!(" {more} further checks fail.")));
    }
    parts
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
        RunStatus::Fault(what) => Some(format!("a run failed: {}", one_line(what))),
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

fn failure(check: &Check, metric: &Metric) -> Vec<AnswerPart> {
    let place = place_words(metric.coordinates());
    let label = metric.definition.label;
    if !metric.is_applicable() {
        let reason = metric.reason().unwrap_or_else(|| "there is no number".to_owned());
        let text = format!("A check fails: the {label}{place} has no value, because {reason}.");
        return vec![AnswerPart::Failure(text)];
    }
    vec![
        AnswerPart::Failure("A check fails: ".to_owned()),
        AnswerPart::words(format!("the {label}{place} is ")),
        number(metric, Some(false)),
        AnswerPart::words(format!("{}.", requirement(check, metric))),
    ]
}

/// What the requested plots show, then what the checks found, those of conservation laws last. Without any of these, nothing states
/// what the experiment asks for, and there is no answer.
pub(super) fn findings(source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let plots = source.record.map_or(&[][..], |record| &record.plots);
    let shown = plots.iter().filter(|plot| !plot.is_of_channel()).map(|plot| Check {
        metric: plot.y.clone(),
        at: plot.at.clone(),
        bound: Bound::Range { minimum: None, maximum: None },
        if_undecided: IfUndecided::Pass,
        line: 0,
    });
    let shown = shown.map(|plot| (None, checked_metrics(&plot, source.metrics)));
    let checked = source.checks.iter().copied();
    let checked = checked.map(|check| (Some(check), checked_metrics(check, source.metrics)));
    let mut findings: Vec<Finding<'_>> = Vec::new();
    for (check, metrics) in shown.chain(checked).filter(|(_, metrics)| !metrics.is_empty()) {
        match findings.iter_mut().find(|it| it.metrics[0].name() == metrics[0].name()) {
            Some(known) => known.add(check, &metrics),
            None => findings.push(Finding { check, has_places: false, metrics }),
        }
    }
    findings.retain(|finding| finding.metrics.iter().all(|metric| metric.is_applicable()));
    findings.sort_by_key(|it| it.metrics.iter().any(|metric| metric.is_of_conservation_law()));
    let sentences = findings.iter().take(MOST_SENTENCES).map(Finding::sentence).collect::<Vec<_>>();
    if sentences.is_empty() { unfinished(source) } else { joined(sentences) }
}

/// What is known of one metric.
struct Finding<'a> {
    /// The first check of it; `None` for a plot.
    check: Option<&'a Check>,
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
        RunStatus::Fault(what) => Some(format!("No answer: the run failed, {}.", one_line(what))),
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
    let everywhere = match metrics.len() {
        2 => " at both points of the sweep".to_owned(),
        all => format!(" at all {all} points of the sweep"),
    };
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
    let relation = if has_places { String::new() } else { common_relation(check, metrics) };
    let text = |metric: &Metric| metric_text(metric, NumberForm::default());
    if text(least) == text(greatest) && !has_places {
        let end = AnswerPart::words(format!("{everywhere}{relation}."));
        return vec![start, number(least, is_passed), end];
    }
    let mut parts = vec![start];
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
    } else {
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
    parts.push(AnswerPart::words(format!("{relation}.")));
    parts
}

/// How far from theory several points are at most; empty if no check compares them.
fn common_relation(check: Option<&Check>, metrics: &[&Metric]) -> String {
    let is_outside = |metric: &&&Metric| metric.theory.is_some_and(|theory| !theory.in_range());
    if let Some(outside) = metrics.iter().find(is_outside) {
        return to_theory(outside);
    }
    if check.is_none() {
        return String::new();
    }
    let sigma = |metric: &&Metric| match metric.deviation() {
        Some(Deviation::StandardErrors(sigma)) => Some(sigma.abs()),
        Some(Deviation::Rounding) => Some(0.0),
        _ => None,
    };
    let sigmas: Option<Vec<f64>> = metrics.iter().map(sigma).collect();
    match sigmas.and_then(|all| all.into_iter().reduce(f64::max)) {
        Some(0.0) => return ", equal to theory".to_owned(),
        Some(worst) if worst <= 1.0 => return ", within one standard error of theory".to_owned(),
        Some(worst) => {
            return format!(", within {} standard errors of theory", significant(worst, 2));
        }
        None => {}
    }
    let is_inside =
        |metric: &&Metric| matches!(metric.deviation(), Some(Deviation::Bound { is_inside: true }));
    let all_inside = metrics.iter().all(is_inside);
    if all_inside { ", inside the accuracy of the law".to_owned() } else { String::new() }
}

fn number(metric: &Metric, is_passed: Option<bool>) -> AnswerPart {
    AnswerPart::Number(answer_number(metric, is_passed))
}

fn answer_number(metric: &Metric, is_passed: Option<bool>) -> AnswerNumber {
    let text = metric_text(metric, NumberForm::default());
    AnswerNumber { metric: metric.name(), text, is_passed }
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

/// The point of a sweep in words, such as " at a friction of 0.5"; empty for a single run.
fn place_words(coordinates: &[Coordinate]) -> String {
    let words = coordinates.iter().map(|coordinate| {
        let value = one_line(&shown_value(coordinate)).into_owned();
        if coordinate.key == VARIANT {
            return format!(" ({value})");
        }
        let unit = unit_of_key(&coordinate.key);
        let words = key_words(&coordinate.key, unit);
        // A number of things.
        if unit == "1" && words.ends_with('s') {
            return format!(" with {value} {words}");
        }
        format!(" at {} {value}{}", words, unit_words(unit))
    });
    words.collect()
}

/// The name of a key without its unit, with spaces.
fn key_words(key: &str, unit: &str) -> String {
    let name = last_part(key);
    let suffix = format!(
        "_{}",
        unit.to_lowercase().replace('/', "_per_").replace('^', "").replace(' ', "_")
    );
    let name = name.strip_suffix(&suffix).unwrap_or(name);
    let name = if unit == "d" { name.strip_suffix("_days").unwrap_or(name) } else { name };
    name.replace('_', " ")
}
