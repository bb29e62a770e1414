//! The answer of an experiment in one or two sentences: the manifest's own with its numbers, or one that follows from the checks.
//!
//! A failed check comes first. No number is invented: where a value is missing, the sentence states why.

mod composed;
mod dependence;
mod missing_runs;
mod number;
mod phrase;
mod place;
mod points;
mod question;
mod relation;
mod settings;
mod template;
mod unanswered;
mod undecided;
mod variable;
mod yes_or_no;

pub(crate) use number::AnswerNumber;

use crate::checks::{checked_metrics, compare};
use crate::metric::Metric;
use crate::metric_files::document::{AnswerEntry, NumberEntry};
use crate::run::RunAnalysis;
use crate::sweep::fits::Refusal;
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::{Check, ExperimentRecord, TimingTable};

/// The answer of an experiment; empty if nothing is known that answers a question.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Answer {
    /// Words and numbers in order.
    pub(crate) parts: Vec<AnswerPart>,
    /// The ratio of run times, which belongs to one machine and is not part of `metrics.json`.
    pub(crate) timing: Option<String>,
}

/// A part of an answer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum AnswerPart {
    /// Words.
    Text(String),
    /// Words about a failure.
    Failure(String),
    /// A measured number.
    Number(AnswerNumber),
    /// Why there is no number.
    Missing(String),
}

/// What an answer is derived from.
#[derive(Clone, Copy)]
pub(crate) struct AnswerSource<'a> {
    /// The experiment, if its record is next to the recordings.
    pub(crate) record: Option<&'a ExperimentRecord>,
    /// The runs that were read.
    pub(crate) runs: &'a [RunAnalysis],
    /// All metrics.
    pub(crate) metrics: &'a [Metric],
    /// The checks that apply.
    pub(crate) checks: &'a [&'a Check],
    /// The fits that failed.
    pub(crate) refusals: &'a [Refusal],
    /// The run times, if they were measured.
    pub(crate) timing: Option<&'a TimingTable>,
}

impl AnswerSource<'_> {
    /// The checks of a metric.
    fn checks_of(&self, metric: &Metric) -> impl Iterator<Item = &Check> {
        let applies = move |check: &&&Check| {
            check.metric == metric.name()
                && checked_metrics(check, self.metrics).iter().any(|it| std::ptr::eq(*it, metric))
        };
        self.checks.iter().filter(applies).copied()
    }

    /// Whether the checks of a metric pass; `None` without a check.
    fn is_passed(&self, metric: &Metric) -> Option<bool> {
        let results = self.checks_of(metric).map(|check| compare(check, metric).passed);
        results.reduce(|all, passed| all && passed)
    }
}

impl Answer {
    /// The answer of an experiment.
    pub(crate) fn of(source: &AnswerSource<'_>) -> Self {
        let mut parts = composed::failures(source);
        let template = source.record.and_then(|record| record.answer.as_ref());
        let answer = match template {
            Some(template) => template::parts(template, source),
            None if parts.is_empty() => composed::findings(source),
            None => composed::main_sentence(source),
        };
        if !parts.is_empty() && !answer.is_empty() {
            parts.push(AnswerPart::words(" "));
        }
        let is_composed = template.is_none() && !answer.is_empty();
        parts.extend(answer);
        parts.extend(composed::remark_on_missing_runs(source).filter(|_| is_composed));
        let timing = composed::timing(source);
        if parts.is_empty() && timing.is_none() {
            parts.extend(composed::without_quantity(source));
        }
        Self { parts, timing }
    }

    /// Whether there is no answer.
    pub(crate) fn is_empty(&self) -> bool {
        self.parts.is_empty() && self.timing.is_none()
    }

    /// The metrics of its numbers, in order.
    pub(crate) fn metrics(&self) -> impl Iterator<Item = &'static str> {
        self.parts.iter().filter_map(|part| match part {
            AnswerPart::Number(number) => Some(number.metric),
            _ => None,
        })
    }

    /// The answer in one line.
    pub(crate) fn text(&self) -> String {
        let timing = self.timing.iter().map(|sentence| format!(" {sentence}"));
        let text: String = self.parts.iter().map(AnswerPart::text).chain(timing).collect();
        one_line(&text.split_whitespace().collect::<Vec<_>>().join(" ")).into_owned()
    }

    /// The answer as `metrics.json` contains it.
    pub(crate) fn entry(&self) -> Option<AnswerEntry> {
        let numbers = self.parts.iter().filter_map(|part| match part {
            AnswerPart::Number(number) => Some(NumberEntry {
                metric: number.metric.to_owned(),
                text: number.text.clone(),
                passed: number.is_passed,
            }),
            _ => None,
        });
        let numbers = numbers.collect();
        let untimed = Self { parts: self.parts.clone(), timing: None };
        (!untimed.is_empty()).then(|| AnswerEntry { text: untimed.text(), numbers })
    }
}

impl AnswerPart {
    /// Words.
    fn words(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// The part as plain text.
    fn text(&self) -> String {
        match self {
            Self::Text(text) | Self::Failure(text) => text.clone(),
            Self::Number(number) if number.mark() == Some(false) => {
                format!("{} (its check fails)", number.text)
            }
            Self::Number(number) => number.text.clone(),
            Self::Missing(reason) => missing_text(reason),
        }
    }
}

/// The words in place of a missing number.
pub(crate) fn missing_text(reason: &str) -> String {
    format!("(no value: {reason})")
}
