//! Sentences that follow from the checks and the requested plots, for a manifest without an answer of its own, and for checks that fail.

use super::dependence::order;
use super::missing_runs::{first_clause, is_whole, missing_runs};
use super::number::{
    NumberForm, compared_form, conserved, form_of, metric_text, number_with, percent, size_text,
    stated_tolerance,
};
use super::phrase::{events_per_disc, phrase, span};
use super::place::place_words;
use super::points::{everywhere, listed, several};
use super::question::{
    asks_for_order, asks_for_pace, asks_if_kept, has_last_word, is_named_in_question,
    is_of_asked_kind, shared_words,
};
use super::relation::{relation, requirement, states_requirement, states_value, to_theory};
use super::settings::with_settings;
use super::unanswered::{is_other_subject, remark};
use super::undecided::{missing_value, undecided_value, without_value};
use super::variable::is_set_by_manifest;
use super::yes_or_no::decided;
use super::{AnswerNumber, AnswerPart, AnswerSource};
use crate::checks::{checked_metrics, compare, undecided_because};
use crate::input::coordinates::text;
use crate::metric::{Definition, Metric, MetricScope, Theory};
use crate::models::main_results;
use crate::number_text::{plus_minus, significant};
use crate::run::{RunAnalysis, RunStatus};
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::{Bound, Check, ExpectedOutcome, IfUndecided, TimingComparison};
use std::cmp::Reverse;
use std::collections::BTreeSet;

/// That the answer may be about something else than the question.
const UNCHOSEN: &str = "The question names no quantity of the runs: these are main results of the model. A check, or the key `answer`, selects others.";
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
        let mut decided = Vec::new();
        for metric in failed {
            match undecided_because(check, metric) {
                Some(reason) => failures.push(undecided_value(metric, &reason)),
                None => decided.push(metric),
            }
        }
        failures.extend((!decided.is_empty()).then(|| failure(check, &decided, all)));
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

/// What the requested plots show, then what the checks found, and whether a plot shows any.
fn chosen_findings<'a>(source: &AnswerSource<'a>) -> (Vec<Finding<'a>>, bool) {
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
    let (mut findings, mut is_shown): (Vec<Finding<'a>>, bool) = (Vec::new(), false);
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
    (findings, is_shown)
}

/// What the requested plots show, then what the checks found, those of conservation laws last. Without a requested plot, and if no check is of a main
/// result of what the manifest sets, the main results follow, so that every experiment has an answer.
pub(super) fn findings(source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let (mut findings, is_shown) = chosen_findings(source);
    let main = main_findings(source);
    let is_main_name = |name: &str| main_names(source).contains(&name);
    let is_main = |finding: &Finding<'_>| main.iter().any(|it| it.name() == finding.name());
    let is_answered = is_shown || findings.iter().any(is_main);
    if !is_answered || findings.iter().all(Finding::is_of_conservation_law) {
        findings.extend(main);
        // Checks come first, unless the question has words of a main result only.
        findings.sort_by_key(|finding| Reverse(shared_words(source, finding.name())));
    }
    let best = findings.iter().map(|it| shared_words(source, it.name())).max().unwrap_or(0);
    let is_chosen = is_shown || findings.iter().any(|it| it.check.is_some());
    // What the manifest chooses comes first if the question names it, unless it asks for a quantity of another kind.
    findings.splice(0..0, asked_finding(best, best > 0 && is_chosen, source));
    let question = source.record.map_or("", |record| &record.question).to_lowercase();
    findings.sort_by_key(|it| it.is_of_conservation_law() && !asks_if_kept(&question));
    let is_asked = |finding: &Finding<'_>| shared_words(source, finding.name()) > 0;
    // The question names a main result already: others of the model do not belong to the answer.
    if findings.first().is_some_and(|first| is_main_name(first.name()) && is_asked(first)) {
        findings.retain(|it| it.check.is_some() || is_asked(it) || !is_main_name(it.name()));
    }
    let names: Vec<&str> = findings.iter().map(Finding::name).collect();
    let remark = remark(source, &names);
    let shown = findings.iter().take(MOST_SENTENCES - usize::from(remark.is_some()));
    let mut sentences = shown.map(|finding| finding.sentences(source)).collect::<Vec<_>>();
    let order = findings.first().and_then(|finding| order(&finding.metrics));
    if let Some(order) = order.filter(|_| asks_for_order(source)) {
        let limit = match findings[0].metrics.len() {
            2 => ", as far as two time steps show",
            _ => "",
        };
        let sentence = format!("The method is of order {order}{limit}.");
        sentences.insert(0, vec![AnswerPart::words(sentence)]);
    }
    if sentences.is_empty() {
        return unfinished(source);
    }
    if let Some(remark) = remark {
        sentences.insert(0, vec![AnswerPart::words(remark)]);
        return joined(sentences);
    }
    if !is_chosen && is_other_subject(source, &names) {
        sentences.push(vec![AnswerPart::words(UNCHOSEN)]);
    }
    let mut sentences = with_settings(sentences, source);
    if let Some(first) = findings.first().filter(|first| is_asked(first)) {
        let sentence = decided(&question, sentences.remove(0), &first.metrics);
        sentences.insert(0, sentence);
        sentences.extend(halving(first, source));
    }
    joined(sentences)
}

/// In how many events per disc a quantity that is far below its start is halved on average, for a question about its pace.
fn halving(finding: &Finding<'_>, source: &AnswerSource<'_>) -> Option<Vec<AnswerPart>> {
    let ([metric], [run]) = (finding.metrics.as_slice(), source.runs) else { return None };
    let is_ratio = metric.definition.label.ends_with("to that at the start");
    let is_halved = is_ratio && metric.value() > 0.0 && metric.value() < 0.5;
    let events = f64::from(events_per_disc(run).filter(|_| is_halved && asks_for_pace(source))?);
    let each = significant(events / -libm::log2(metric.value()), 2);
    Some(vec![AnswerPart::words(format!("On average, it is halved every {each} events per disc."))])
}

/// The main results of what the manifests set, the most telling one first.
fn main_names(source: &AnswerSource<'_>) -> Vec<&'static str> {
    let mut names: Vec<&'static str> = Vec::new();
    for name in source.runs.iter().flat_map(|run| main_results(run.model()).metrics) {
        if !names.contains(name) {
            names.push(name);
        }
    }
    names
}

/// The values of a metric everywhere, if every run has it.
fn finding<'a>(name: &str, source: &AnswerSource<'a>) -> Option<Finding<'a>> {
    let everywhere = Check {
        metric: name.to_owned(),
        at: Vec::new(),
        bound: Bound::Range { minimum: None, maximum: None },
        if_undecided: IfUndecided::Pass,
        line: 0,
    };
    let metrics = checked_metrics(&everywhere, source.metrics);
    let is_known = !metrics.is_empty() && metrics.iter().all(|metric| metric.is_applicable());
    is_known.then_some(Finding { check: None, is_everywhere: true, has_places: false, metrics })
}

/// The quantity that the question names, or whose kind it asks for, if every run has it and if more than `best` words are those of the question.
fn asked_finding<'a>(
    best: usize,
    is_by_kind: bool,
    source: &AnswerSource<'a>,
) -> Option<Finding<'a>> {
    let question = source.record.map_or("", |record| &record.question);
    let is_kept = asks_if_kept(&question.to_lowercase());
    let is_asked = |metric: &&Metric| {
        let Definition { label, unit, .. } = metric.definition;
        let law = metric.theory.and_then(|theory| theory.law);
        let is_of_question = |quantity| is_kept && has_last_word(question, quantity);
        let is_conserved = law.and_then(|law| law.conserved).is_some_and(is_of_question);
        !is_by_kind && (is_conserved || is_named_in_question(source, label))
            || is_of_asked_kind(question, label, unit)
    };
    let is_set = |metric: &Metric| {
        let is_it = |other: &&Metric| other.name() == metric.name() && is_set_by_manifest(other);
        source.metrics.iter().any(|other| is_it(&other))
    };
    let is_result = |metric: &&Metric| {
        let is_cause = best > 0 && is_set(metric);
        let is_result = !metric.is_of_conservation_law() || is_kept;
        is_result && !is_cause && !metric.is_fit()
    };
    let mut asked: Vec<&Metric> =
        source.metrics.iter().filter(is_asked).filter(is_result).collect();
    asked.retain(|metric| shared_words(source, metric.name()) > best);
    asked.sort_by_key(|metric| Reverse(shared_words(source, metric.name())));
    asked.into_iter().find_map(|metric| finding(metric.name(), source))
}

/// The main metrics of what the manifests set, as far as every run has them.
fn main_findings<'a>(source: &AnswerSource<'a>) -> Vec<Finding<'a>> {
    let names = main_names(source);
    let mut findings: Vec<Finding<'_>> =
        names.iter().filter_map(|name| finding(name, source)).collect();
    findings.sort_by_key(|finding| Reverse(shared_words(source, finding.name())));
    findings
}

/// What the main metrics of the model show, in a sentence after failed checks of others.
pub(super) fn main_sentence(source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let is_checked =
        |finding: &Finding<'_>| source.checks.iter().any(|check| check.metric == finding.name());
    let findings = main_findings(source);
    let first = findings.iter().find(|finding| !is_checked(finding));
    first.map_or_else(Vec::new, |finding| finding.sentence(source))
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
        let mut parts = self.sentence(source);
        if missing > 0 && is_of_points {
            let has = if missing == 1 { "has" } else { "have" };
            parts.push(AnswerPart::words(format!(" {missing} of {points} points {has} no value.")));
        }
        parts
    }

    fn sentence(&self, source: &AnswerSource<'_>) -> Vec<AnswerPart> {
        match self.metrics.as_slice() {
            [metric] => single(self.check, metric, source),
            metrics => {
                let compared = self.check.filter(|check| states_value(check));
                several(compared.map(|_| true), metrics, self.has_places, source)
            }
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

/// What complete runs without any quantity consist of, and what gives them an answer.
pub(super) fn without_quantity(source: &AnswerSource<'_>) -> Option<AnswerPart> {
    let run = source.runs.iter().find(|run| run.is_complete())?;
    let (frames, particles) = (run.frames, run.model().particles());
    let kind = match run.model() {
        ModelConfig::Dem(_) | ModelConfig::Packing(_) => "disc",
        ModelConfig::Orbit(_) => "body",
        _ => "particle",
    };
    let kind = match (particles, kind) {
        (1, one) => one.to_owned(),
        (_, "body") => "bodies".to_owned(),
        (_, one) => format!("{one}s"),
    };
    let unit = if frames == 1 { "frame" } else { "frames" };
    let runs = match source.runs.len() {
        1 => format!("The run has {frames} {unit} of {particles} {kind} and"),
        several => format!("The {several} runs have"),
    };
    Some(AnswerPart::words(format!(
        "{runs} no checked quantity. The key `answer` of the manifest, or a check, states what to report."
    )))
}

fn single(check: Option<&Check>, metric: &Metric, source: &AnswerSource<'_>) -> Vec<AnswerPart> {
    let place = place_words(metric.coordinates());
    let is_passed = check.map(|_| true);
    if let Some(conserved) = conserved(metric) {
        return vec![
            AnswerPart::words(format!("The {conserved}{place} is conserved to ")),
            AnswerPart::Number(number_with(metric, size_text(metric), is_passed)),
            AnswerPart::words("."),
        ];
    }
    let below = below_center(metric).filter(|_| check.is_none());
    let (metric, label) = match &below {
        Some((depth, label)) => (depth, label.as_str()),
        None => (metric, metric.definition.label),
    };
    let mut relation = check.map_or_else(|| to_theory(metric), |check| relation(check, metric));
    if relation.is_empty() {
        relation = to_start(metric, source).unwrap_or_default();
    }
    let phrase = phrase(metric, label, &relation, span(metric, source).as_deref());
    let form = NumberForm { is_size: phrase.is_size, ..compared_form(metric) };
    let tolerance = check.and_then(|check| stated_tolerance(check, metric));
    let number = number_with(metric, metric_text(metric, form), is_passed);
    let is_compared = check.is_none_or(|check| states_requirement(check, metric));
    vec![
        AnswerPart::words(phrase.before),
        AnswerPart::Number(AnswerNumber { tolerance, is_compared, ..number }),
        AnswerPart::words(format!("{}{relation}.", phrase.after)),
    ]
}

/// A height below 0 as a depth, with its label; `None` for other metrics.
fn below_center(metric: &Metric) -> Option<(Metric, String)> {
    let (label, has_depth) = (metric.definition.label, metric.value() < 0.0);
    let quantity = label.strip_suffix(" above the center").filter(|_| has_depth)?;
    let mut depth = metric.clone();
    depth.estimate.value = -depth.estimate.value;
    depth.theory = depth.theory.map(|theory| Theory { value: -theory.value, ..theory });
    Some((depth, format!("{} below the center", quantity.replace("height", "depth"))))
}

/// A value at the end as a fraction of the same quantity at the start, if that is a metric.
fn to_start(metric: &Metric, source: &AnswerSource<'_>) -> Option<String> {
    let is_start = |other: &&Metric| {
        other.name().strip_suffix(".start") == Some(metric.name())
            && other.coordinates() == metric.coordinates()
            && other.is_applicable()
    };
    let mut starts = source.metrics.iter().filter(is_start);
    let start = starts.next().filter(|start| start.value() > 0.0)?;
    let fraction = percent(metric.value() / start.value());
    starts.next().is_none().then(|| format!(", {fraction} of that at the start"))
}

/// The value of a metric as a number of a sentence.
fn number(metric: &Metric, is_passed: Option<bool>) -> AnswerPart {
    let text = metric_text(metric, form_of(metric));
    AnswerPart::Number(number_with(metric, text, is_passed))
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
