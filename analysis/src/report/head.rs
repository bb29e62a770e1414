//! The head of `report.html`: the question and the expected answer, the result with its number, pass or fail, and provenance.

use super::AnalysisReport;
use super::file_links::FileLinks;
use super::markup::{breakable, typographic};
use super::table::{deviation_text, theory_text, value_text};
use crate::checks::{CheckKind, CheckResult, subject};
use crate::input::host_file::utc;
use crate::metric::Metric;
use crate::number_text::{six_digits, with_error};
use kinetoscope_manifest::TimingComparison;
use maud::{Markup, html};
use std::collections::BTreeSet;

/// Separates the question from the expected answer in the first line of a manifest.
const EXPECTED: &str = "Expected:";
/// Maximum number of metrics in the sentence of the result.
const MOST_RESULTS: usize = 4;

/// The head of the page.
pub(super) fn heading(report: &AnalysisReport, links: &FileLinks) -> Markup {
    html! {
        header {
            h1 { (breakable(&report.name)) }
            @if let Some(headline) = report.headline() {
                p { strong class="bad" { "FAILED: " (headline) } }
            }
            @if let Some(unreadable) = report.unreadable_files() {
                p { strong class="bad" { (unreadable) } }
            }
            (question(report))
            (result(report, ""))
            (check_summary(report))
            (provenance(report))
            (links.list())
        }
    }
}

/// The question and the expected answer, by the manifest's first comment lines; then its description.
pub(super) fn question(report: &AnalysisReport) -> Markup {
    let (first, rest) = report.comment.split_once('\n').unwrap_or((&report.comment, ""));
    let (question, answer) = first.split_once(EXPECTED).unwrap_or((first, ""));
    html! {
        @if !question.trim().is_empty() { p class="question" { (question.trim()) } }
        @if !answer.trim().is_empty() { p { span class="facts" { "Expected: " } (answer.trim()) } }
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

fn check_summary(report: &AnalysisReport) -> Markup {
    let (class, summary) = checks_summary(report);
    html! {
        p { strong class=(class) { (summary) } }
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

/// What produced the numbers, by the recordings and the files next to them.
fn provenance(report: &AnalysisReport) -> Markup {
    let facts = facts(report);
    html! {
        dl class="provenance" {
            @for (name, value) in facts { div { dt { (name) } dd { (breakable(&value)) } } }
        }
        // A line of its own, because it differs between machines.
        @if let Some(machine) = machine(report) { p class="machine facts" { (machine) } "\n" }
    }
}

fn facts(report: &AnalysisReport) -> Vec<(&'static str, String)> {
    let distinct = |of: fn(&crate::run::RunAnalysis) -> String| {
        let all: BTreeSet<String> = report.runs.iter().map(of).collect();
        all.into_iter().collect::<Vec<_>>().join(", ")
    };
    let mut facts = vec![("model", report.models_and_runs())];
    if let [run] = report.runs.as_slice() {
        facts.push(("run key", run.origin.run_key.clone()));
    }
    facts.push(("seed", distinct(|run| run.manifest.seed.to_string())));
    facts.push(("program", distinct(|run| run.origin.program_version.clone())));
    facts.push(("physics", distinct(|run| format!("version {}", run.origin.physics_version))));
    let bytes: u64 = report.sizes.values().sum();
    facts.push(("size", size_text(bytes)));
    facts
}

/// Date, machine and wall time of the runs; `None` without host files.
fn machine(report: &AnalysisReport) -> Option<String> {
    let hosts = &report.hosts;
    let names: BTreeSet<String> = hosts
        .iter()
        .map(|host| {
            let name = host.host.as_deref().unwrap_or("unknown host");
            format!("{name} ({} {})", host.operating_system, host.architecture)
        })
        .collect();
    let date = hosts.iter().filter_map(|host| host.finished_unix_time_s).max();
    let seconds: f64 = hosts.iter().filter_map(|host| host.wall_time_s).sum();
    if hosts.is_empty() {
        return None;
    }
    let names = names.into_iter().collect::<Vec<_>>().join(", ");
    let date = date.map_or_else(String::new, |seconds| format!("{}, ", utc(seconds)));
    let which = match (hosts.len(), report.runs.len()) {
        (1, 1) => "",
        (known, all) if known < all => " of the runs with a host file",
        _ => " of all runs",
    };
    Some(format!("recorded {date}on {names}; wall time{which} {}", duration_text(seconds)))
}

fn size_text(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{} kB", six_digits(libm::round(bytes as f64 / 100.0) / 10.0)),
        _ => format!("{} MB", six_digits(libm::round(bytes as f64 / 1e5) / 10.0)),
    }
}

fn duration_text(seconds: f64) -> String {
    match seconds {
        short if short < 60.0 => format!("{} s", six_digits(libm::round(100.0 * short) / 100.0)),
        minutes if minutes < 5400.0 => {
            format!("{} min", six_digits(libm::round(minutes / 6.0) / 10.0))
        }
        hours => format!("{} h", six_digits(libm::round(hours / 360.0) / 10.0)),
    }
}
