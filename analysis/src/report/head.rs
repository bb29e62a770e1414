//! The head of `report.html`: the question, the result with its number, and pass or fail.

use super::AnalysisReport;
use super::markup::{breakable, typographic};
use super::table::{deviation_text, theory_text, value_text};
use crate::checks::{CheckKind, CheckResult, subject};
use crate::metric::Metric;
use crate::number_text::with_error;
use kinetoscope_manifest::TimingComparison;
use maud::{Markup, html};
use std::collections::BTreeSet;

/// Separates the question from the expected answer in the first line of a manifest.
const EXPECTED: &str = "Expected:";
/// Maximum number of metrics in the sentence of the result.
const MOST_RESULTS: usize = 4;

/// The question, by the manifest's first comment line.
pub(super) fn question(report: &AnalysisReport) -> Markup {
    let question = report.comment.lines().next().unwrap_or_default();
    let question = question.split_once(EXPECTED).map_or(question, |(question, _)| question).trim();
    html! { @if !question.is_empty() { p class="question" { (question) } } }
}

/// What the manifest states in addition to its question: the expected answer, further comment lines and the description.
pub(super) fn background(report: &AnalysisReport) -> Markup {
    let (first, rest) = report.comment.split_once('\n').unwrap_or((&report.comment, ""));
    let answer = first.split_once(EXPECTED).map_or("", |(_, answer)| answer).trim();
    html! {
        @if !answer.is_empty() { p { span class="facts" { "Expected: " } (answer) } }
        @for line in rest.lines().filter(|line| !line.is_empty()) { p class="facts" { (line) } }
        @if !report.description.is_empty() { p { (report.description) } }
    }
}

/// The result in one sentence: the failed checks with their reasons, else the ratio of run times, else the first requested plot, else the
/// metrics of the first checks, conservation laws last. Without any of these, nothing says what the experiment asks for, and there is no
/// result. `page` is the address of the report in the page that shows the sentence; empty in the report itself.
pub(super) fn result(report: &AnalysisReport, page: &str) -> Markup {
    let mut subjects = BTreeSet::new();
    let checks: Vec<&CheckResult> = report
        .check_results
        .iter()
        .filter(|result| result.kind == CheckKind::Check)
        .filter(|result| subjects.insert((result.passed, &result.subject)))
        .collect();
    let failed = checks.iter().filter(|result| !result.passed);
    let failed: Vec<Markup> = failed.map(|result| failure(result)).take(MOST_RESULTS).collect();
    if !failed.is_empty() {
        return sentence(&failed);
    }
    if let Some(table) = &report.timing
        && let Some(TimingComparison { of, over, all, .. }) = &table.comparison
    {
        let ratio = with_error(all.mean, Some(all.standard_error));
        return sentence(&[
            html! { "time of " (of) " over time of " (over) " = " strong { (ratio) } },
        ]);
    }
    if let Some(command) = timing_command(&report.comment).filter(|_| report.timing.is_none()) {
        return sentence(&[html! { "none yet; run " code { (command) " --output DIR" } }]);
    }
    if let Some((stem, plot)) = report.first_requested_plot() {
        return sentence(&[html! { a href=(format!("{page}#plot-{stem}")) { (plot.title) } }]);
    }
    let mut metrics: Vec<&Metric> =
        checks.iter().filter_map(|result| metric_of(report, result)).collect();
    metrics.sort_by_key(|metric| metric.is_of_conservation_law());
    let clauses: Vec<Markup> = metrics.into_iter().map(clause).take(MOST_RESULTS).collect();
    sentence(&clauses)
}

/// The clauses of the result; nothing if there are none.
fn sentence(clauses: &[Markup]) -> Markup {
    html! {
        @if !clauses.is_empty() {
            p class="result" {
                "Result: "
                @for (index, clause) in clauses.iter().enumerate() {
                    @if index > 0 { "; " br; }
                    (clause)
                }
                "."
            }
        }
    }
}

/// A failed check with its reason.
fn failure(result: &CheckResult) -> Markup {
    html! { (breakable(&result.subject)) " " strong class="bad" { "fails" } ": " (typographic(&result.finding)) }
}

/// The metric that a check found.
fn metric_of<'a>(report: &'a AnalysisReport, result: &CheckResult) -> Option<&'a Metric> {
    report.metrics.iter().find(|metric| subject(metric) == result.subject)
}

/// The command in the manifest's first comment lines whose table of run times is the result.
fn timing_command(comment: &str) -> Option<&str> {
    comment.lines().map(str::trim).find(|line| line.starts_with("kinetoscope benchmark "))
}

/// A metric in a clause, such as "slope = 4.40(2) N/(m K), theory 4.39, +0.5 σ".
fn clause(metric: &Metric) -> Markup {
    let unit = if metric.unit() == "1" { "" } else { metric.unit() };
    let (theory, deviation) = (theory_text(metric), deviation_text(metric));
    let place = subject(metric);
    let place = place.strip_prefix(metric.name()).unwrap_or_default();
    html! {
        (breakable(metric.name())) (place) " = "
        strong { (typographic(&value_text(metric))) }
        @if !unit.is_empty() { " " (unit) }
        @if !theory.is_empty() { ", theory " (typographic(&theory)) }
        @if let Some(violation) = metric.theory.and_then(|theory| theory.violation) {
            ", outside the range of its law: " (violation)
        }
        @else if !deviation.is_empty() { ", deviation " (typographic(&deviation)) }
    }
}

/// How many checks pass, with the class of its color.
pub(super) fn checks_summary(report: &AnalysisReport) -> (&'static str, String) {
    let checks = || report.check_results.iter().filter(|result| result.kind != CheckKind::Outcome);
    match (checks().count(), checks().filter(|result| !result.passed).count()) {
        (0, _) => ("", "no checks".to_owned()),
        (1, 0) => ("good", "the check passes".to_owned()),
        (all, 0) => ("good", format!("all {all} checks pass")),
        (all, failed) => ("bad", format!("{failed} of {all} checks failed")),
    }
}
