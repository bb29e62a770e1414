//! The head of `report.html`: the question and the expected answer, the answer with its numbers, pass or fail, and provenance.

use super::AnalysisReport;
use super::file_links::FileLinks;
use super::markup::breakable;
use crate::answer::{AnswerNumber, AnswerPart, missing_text};
use crate::checks::CheckKind;
use crate::input::host_file::utc;
use crate::number_text::six_digits;
use maud::{Markup, html};
use std::collections::BTreeSet;

/// Separates the question from the expected answer in the first line of a manifest.
const EXPECTED: &str = "Expected:";

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
            (about(report))
            (provenance(report))
            (links.list())
        }
    }
}

/// The question.
pub(super) fn question(report: &AnalysisReport) -> Markup {
    html! {
        @if !report.question.is_empty() { p class="question" { (report.question) } }
    }
}

/// What is run, and the expected answer by the manifest's first comment.
fn about(report: &AnalysisReport) -> Markup {
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

/// The answer in one or two sentences, with a link to the plot that the manifest requests first. `page` is the address of the report in
/// the page that shows the sentence; empty in the report itself.
pub(super) fn result(report: &AnalysisReport, page: &str) -> Markup {
    html! {
        @if !report.answer.is_empty() {
            p class="result" {
                @for part in &report.answer.parts { (answer_part(part)) }
                @if let Some(timing) = &report.answer.timing { " " (timing) }
                @if let Some((stem, plot)) = report.first_requested_plot() {
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
            AnswerPart::Text(text) => (text),
            AnswerPart::Failure(text) => strong class="bad" { (text) },
            AnswerPart::Number(AnswerNumber { text, is_passed, .. }) => {
                strong { (text) }
                @match is_passed {
                    Some(true) => span class="good" title="the check passes" { "\u{a0}✓" },
                    Some(false) => strong class="bad" { " (its check fails)" },
                    None => {},
                }
            },
            AnswerPart::Missing(reason) => em { (missing_text(reason)) },
        }
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
