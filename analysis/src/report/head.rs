//! The head of `report.html`: the question, the answer with its numbers, and pass or fail.

use super::AnalysisReport;
use super::markup::breakable;
use crate::answer::{AnswerPart, missing_text};
use crate::checks::CheckKind;
use maud::{Markup, html};

/// Separates the question from the expected answer in the first line of a manifest.
const EXPECTED: &str = "Expected:";

/// What a badge means.
const PASSES: &str = "the check passes";

/// The question.
pub(super) fn question(report: &AnalysisReport) -> Markup {
    html! { @if !report.question.is_empty() { p class="question" { (with_subscripts(&report.question)) } } }
}

/// The question as the title of its page; without one, the name.
pub(super) fn title(report: &AnalysisReport) -> Markup {
    html! {
        @if report.question.is_empty() { h1 { (breakable(&report.name)) } }
        @else { h1 class="question" { (with_subscripts(&report.question)) } }
    }
}

/// What the manifest states in addition to its question: the expected answer, further comment lines and the description.
pub(super) fn background(report: &AnalysisReport) -> Markup {
    let (first, rest) = report.comment.split_once('\n').unwrap_or((&report.comment, ""));
    let (before, expected) = first.split_once(EXPECTED).unwrap_or((first, ""));
    let note = Some(before.trim()).filter(|note| *note != report.question);
    html! {
        @if !report.description.is_empty() { p { (report.description) } }
        @if !expected.trim().is_empty() { p { span class="facts" { "Expected: " } (expected.trim()) } }
        @for line in note.into_iter().chain(rest.lines()).filter(|line| !line.is_empty()) {
            p class="facts" { (line) }
        }
    }
}

/// The answer in one or two sentences, elsewhere than in the report with a link to the plot that the manifest requests first. `page` is the address of the
/// report in the page that shows the sentence; empty in the report itself, where the plot is on the first screen.
pub(super) fn result(report: &AnalysisReport, page: &str) -> Markup {
    html! {
        @if !report.answer.is_empty() {
            p class="result" {
                @for part in &report.answer.parts { (answer_part(part)) }
                @if let Some(timing) = &report.answer.timing { " " (timing) }
                @if !page.is_empty() && let Some((stem, plot)) = report.first_requested_plot() {
                    " " a href=(format!("{page}#plot-{stem}")) title=(plot.title) { "Plot" }
                }
            }
        }
    }
}

/// Words, a number in bold with the badge of its checks, or the reason why there is no number.
fn answer_part(part: &AnswerPart) -> Markup {
    html! {
        @match part {
            AnswerPart::Text(text) => (with_subscripts(&unbroken(text))),
            AnswerPart::Failure(text) => strong class="bad" { (text) },
            AnswerPart::Number(number) => {
                strong { (with_subscripts(&number.text.replace(' ', "\u{a0}"))) }
                @match number.mark() {
                    Some(true) => {
                        span class="good" role="img" title=(PASSES) aria-label=(PASSES) { "\u{a0}✓" }
                        // A deviation of many standard errors passes by the tolerance only.
                        @if let Some(tolerance) = &number.tolerance { span class="good" { " " (tolerance.replace(' ', "\u{a0}")) } }
                    },
                    Some(false) => strong class="bad" { " (its check fails)" },
                    None => {},
                }
            },
            AnswerPart::Missing(reason) => em { (missing_text(reason)) },
        }
    }
}

/// A text with spaces that do not break between a number and its error, and between a number and its unit, which begins the text if a number precedes it.
fn unbroken(text: &str) -> String {
    let mut unbroken = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(place) = rest.find(' ') {
        let (before, after) = (&rest[..place], &rest[place + 1..]);
        unbroken += before;
        let is_after_number = match unbroken.chars().next_back() {
            Some(last) => {
                last.is_ascii_digit() || matches!(last, ')' | '⁰'..='⁹' | '¹' | '²' | '³' | '±')
            }
            None => true,
        };
        let word = after.split([' ', ',', '.', ';', ')']).next().unwrap_or_default();
        let is_joined =
            is_after_number && (UNITS.contains(&word) || word == "±" || unbroken.ends_with('±'));
        unbroken.push(if is_joined { '\u{a0}' } else { ' ' });
        rest = after;
    }
    unbroken + rest
}

/// What can follow a number as its unit.
const UNITS: [&str; 33] = [
    "%", "AU", "J", "K", "N", "N/m", "Pa", "a", "cm", "d", "day", "days", "degrees", "h", "k_B",
    "kHz", "kg", "km", "m", "m/s", "m/s²", "mJ", "min", "mm", "ms", "m²/s", "m²/s²", "ns", "per",
    "rad", "s", "times", "µs",
];

/// A text with the subscript of Boltzmann's constant, and with keys, between pairs of backticks, as code.
fn with_subscripts(text: &str) -> Markup {
    let has_pairs = text.matches('`').count().is_multiple_of(2);
    html! {
        @for (place, words) in text.split(|letter| letter == '`' && has_pairs).enumerate() {
            @if place % 2 == 1 { code { (words) } }
            @else {
                @for (index, part) in words.split("k_B").enumerate() {
                    @if index > 0 { "k" sub { "B" } }
                    (part)
                }
            }
        }
    }
}

/// What the checks are about, if no number of the answer is checked.
pub(super) fn what_is_checked(report: &AnalysisReport) -> &'static str {
    let checked = report.answer.parts.iter().filter_map(|part| match part {
        AnswerPart::Number(number) => Some(number.is_passed.is_some()),
        _ => None,
    });
    if checked.reduce(|any, one| any || one) == Some(false) { " (of other quantities)" } else { "" }
}

/// How many checks pass, with the class of its color; empty without checks.
pub(super) fn checks_summary(report: &AnalysisReport) -> (&'static str, String) {
    let checks = || report.check_results.iter().filter(|result| result.kind != CheckKind::Outcome);
    match (checks().count(), checks().filter(|result| !result.passed).count()) {
        (0, _) => ("", String::new()),
        (1, 0) => ("good", "the check passes".to_owned()),
        (1, _) => ("bad", "the check failed".to_owned()),
        (2, 0) => ("good", "both checks pass".to_owned()),
        (all, 0) => ("good", format!("all {all} checks pass")),
        (all, failed) => ("bad", format!("{failed} of {all} checks failed")),
    }
}
