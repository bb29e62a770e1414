//! `report.html`: one self-contained file for a wide screen, a phone and paper, in light or dark.
//!
//! Text is escaped by the type [`Markup`], and control and bidirectional characters in the whole page; only the style sheet, the script, the SVG documents
//! and the data of replays in base64 are inserted as they are.

use crate::checks::CheckKind;
use crate::checks::baseline::BaselineComparison;
use crate::input::coordinates::label;
use crate::metric::{Definition, Law, Metric, symbols};
use crate::report::AnalysisReport;
use crate::report::replay_section;
use crate::report::table::{
    deviation_text, reasons, six_digits, theory_text, value_text, with_error,
};
use kinetoscope_manifest::{Coordinate, TimingTable};
use kinetoscope_usage::text::visible;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::collections::BTreeSet;

pub(super) const STYLE_SHEET: &str = include_str!("report.css");
const SCRIPT: &str = include_str!("report.js");

/// The page. `plots` are titles and SVG documents, in order.
pub(crate) fn page(report: &AnalysisReport, plots: &[(&str, String)]) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (report.name) }
                style { (PreEscaped(STYLE_SHEET)) }
            }
            body {
                main {
                    (heading(report))
                    (replay_section::section(report))
                    (remarks("Unreadable", "bad", &report.unreadable))
                    (remarks("Notes", "", &report.notes))
                    @if report.headline().is_some() {
                        (check_table(report, CheckKind::Outcome, "Outcomes"))
                    }
                    (check_table(report, CheckKind::Check, "Checks"))
                    @if let Some(comparison) = &report.baseline { (baseline(comparison)) }
                    (figures(plots))
                    @if let Some(table) = &report.timing { (timing(table)) }
                    (numbers(report))
                    (definitions(report))
                    (manifest(report))
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    visible(&(page.into_string() + "\n")).into_owned()
}

fn heading(report: &AnalysisReport) -> Markup {
    let runs = report.runs.len();
    let runs = if runs == 1 { "1 run".to_owned() } else { format!("{runs} runs") };
    let (class, summary) = checks_summary(report);
    html! {
        header {
            h1 { (breakable(&report.name)) }
            @if let Some(headline) = report.headline() {
                p { strong class="bad" { "FAILED: " (headline) } }
            }
            p { (report.description) }
            p class="facts" {
                (report.model()) " · " (runs) " · " strong class=(class) { (summary) }
            }
        }
    }
}

/// How the checks ended, with the class of its color.
pub(super) fn checks_summary(report: &AnalysisReport) -> (&'static str, String) {
    let checks = || report.check_results.iter().filter(|result| result.kind != CheckKind::Outcome);
    match (checks().count(), checks().filter(|result| !result.passed).count()) {
        (0, _) => ("", "no checks".to_owned()),
        (1, 0) => ("good", "the check passes".to_owned()),
        (all, 0) => ("good", format!("all {all} checks pass")),
        (all, failed) => ("bad", format!("{failed} of {all} checks failed")),
    }
}

/// A list of notes, or of what could not be read; nothing for an empty list.
fn remarks(title: &str, class: &str, lines: &[String]) -> Markup {
    html! {
        @if !lines.is_empty() {
            section {
                h2 class=(class) { (title) }
                ul { @for line in lines { li { (line) } } }
            }
        }
    }
}

fn check_table(report: &AnalysisReport, kind: CheckKind, title: &str) -> Markup {
    let results: Vec<_> =
        report.check_results.iter().filter(|result| result.kind == kind).collect();
    html! {
        @if !results.is_empty() {
            section {
                h2 { (title) }
                table class="checks" {
                    thead { tr { th {} th { "metric" } th { "finding" } } }
                    tbody {
                        @for result in results {
                            @let (class, word) =
                                if result.passed { ("good", "ok") } else { ("bad", "failed") };
                            tr {
                                td { strong class=(class) { (word) } }
                                td { (breakable(&result.subject)) }
                                td { (result.finding) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// All metrics of both analyses, the worst first.
fn baseline(comparison: &BaselineComparison) -> Markup {
    let number = |value: Option<f64>| {
        value.map_or_else(String::new, |value| typographic(&six_digits(value)))
    };
    html! {
        section {
            h2 { "Against the baseline" }
            @for rule in &comparison.rules { p { (rule) } }
            @for (subject, finding) in comparison.failures() {
                p { strong class="bad" { "failed" } " " (breakable(subject)) ": " (finding) }
            }
            table class="numbers" {
                thead {
                    tr {
                        th { "metric" } th { "baseline" } th { "now" } th { "difference" }
                        th { "unit" } th { "σ" } th { "result" }
                    }
                }
                tbody {
                    @for row in &comparison.rows {
                        @let (class, word) = match row.passed {
                            Some(true) => ("good", "ok"),
                            Some(false) => ("bad", "failed"),
                            None => ("", "not compared"),
                        };
                        tr {
                            td { (breakable(&row.subject)) }
                            td data-label="baseline" { (number(row.old)) }
                            td data-label="now" { (number(row.new)) }
                            td data-label="difference" { (number(row.difference())) }
                            td data-label="" { (if row.unit == "1" { "" } else { &row.unit }) }
                            td data-label="" { (row.sigma_text()) }
                            td data-label="" { strong class=(class) { (word) } ": " (row.reason) }
                        }
                    }
                }
            }
        }
    }
}

fn figures(plots: &[(&str, String)]) -> Markup {
    html! {
        @if !plots.is_empty() {
            section {
                h2 { "Plots" }
                div class="plots" {
                    @for (title, svg) in plots { figure { (labeled_svg(title, svg)) } }
                }
            }
        }
    }
}

/// An SVG document of the program's own with its title as a label for screen readers.
fn labeled_svg(title: &str, svg: &str) -> Markup {
    let title = html! { (title) }.into_string();
    let opening = format!("<svg role=\"img\" aria-label=\"{title}\"");
    PreEscaped(svg.replacen("<svg", &opening, 1).trim_end().to_owned())
}

fn numbers(report: &AnalysisReport) -> Markup {
    html! {
        section {
            h2 { "Numbers" }
            p {
                "Digits in brackets are one standard error, in units of the last digits. "
                "σ is the deviation from theory in standard errors; with few degrees of freedom ν it is the equally probable one of a normal distribution, by Student's t. "
                "A theoretical value is followed by the accuracy of its law, if that is not exact."
            }
            @for (title, metrics) in report.sections() {
                h3 { (breakable(&title)) }
                @if !metrics.is_empty() {
                    table class="numbers" {
                        thead {
                            tr {
                                th { "metric" } th { "value" } th { "unit" } th { "theory" }
                                th { "deviation" }
                            }
                        }
                        tbody { @for metric in &metrics { (metric_row(metric)) } }
                    }
                    @let reasons = reasons(&metrics);
                    @if !reasons.is_empty() { ul { @for line in &reasons { li { (breakable(line)) } } } }
                }
            }
        }
    }
}

fn metric_row(metric: &Metric) -> Markup {
    let unit = if metric.unit() == "1" { "" } else { metric.unit() };
    let theory = typographic(&theory_text(metric));
    let deviation = typographic(&deviation_text(metric));
    let label = |label: &'static str, text: &str| if text.is_empty() { "" } else { label };
    html! {
        tr {
            td { (breakable(metric.name())) }
            td data-label="" { (typographic(&value_text(metric))) }
            td data-label="" { (unit) }
            td data-label=(label("theory", &theory)) { (theory) }
            td data-label=(label("deviation", &deviation)) { (deviation) }
        }
    }
}

/// A number with a minus sign in place of the hyphen that terminals and files contain.
fn typographic(number: &str) -> String {
    number.replace('-', "−")
}

/// The run times, which no metric contains.
fn timing(table: &TimingTable) -> Markup {
    html! {
        section {
            h2 { "Timing" }
            p {
                "The engine alone, one run at a time, nothing recorded, " (table.machine)
                ". These figures belong to that machine."
            }
            table class="numbers" {
                thead {
                    tr {
                        th { "point (runs)" } th { "mean/s" } th { "standard deviation/s" }
                        th { "median/s" } th { "steps or events/s" }
                    }
                }
                tbody {
                    @for point in &table.points {
                        @let name = format!("{} ({})", point_name(&point.coordinates), point.runs);
                        tr {
                            td { (breakable(&name)) }
                            td data-label="mean/s" { (four_digits(point.mean_s)) }
                            td data-label="deviation/s" {
                                (four_digits(point.standard_deviation_s))
                            }
                            td data-label="median/s" { (four_digits(point.median_s)) }
                            td data-label="per second" {
                                (four_digits(point.steps_or_events_per_s))
                            }
                        }
                    }
                }
            }
            (time_ratios(table))
        }
    }
}

fn time_ratios(table: &TimingTable) -> Markup {
    html! {
        @if let Some(comparison) = &table.comparison {
            h3 { "Time of " (comparison.of) " over time of " (comparison.over) }
            table class="numbers" {
                thead { tr { th { "point" } th { "geometric mean" } th { "median" } } }
                tbody {
                    @for ratio in comparison.ratios.iter().chain([&comparison.all]) {
                        tr {
                            td { (breakable(&point_name(&ratio.coordinates))) }
                            td data-label="mean" {
                                (with_error(ratio.mean, Some(ratio.standard_error)))
                            }
                            td data-label="median" { (four_digits(ratio.median)) }
                        }
                    }
                }
            }
        }
    }
}

/// The name of a point of a sweep.
fn point_name(coordinates: &[Coordinate]) -> String {
    match label(coordinates) {
        name if name.is_empty() => "all".to_owned(),
        name => name,
    }
}

/// A positive number in four digits.
fn four_digits(value: f64) -> String {
    let unit = 10.0_f64.powf(value.log10().floor() - 3.0);
    six_digits(if value > 0.0 { (value / unit).round() * unit } else { value })
}

/// How each metric of this report is derived, and the laws behind its theoretical value.
fn definitions(report: &AnalysisReport) -> Markup {
    let mut listed = BTreeSet::new();
    let all = report.metrics.iter().map(|metric| metric.definition);
    let definitions = all.filter(|definition| listed.insert((definition.name, definition.how)));
    let definitions: Vec<&Definition> = definitions.collect();
    let formulas = definitions.iter().flat_map(|definition| {
        definition.laws.iter().map(|law| law.statement).chain([definition.how])
    });
    let symbols: Vec<String> =
        symbols::used(formulas).map(|(symbol, meaning)| format!("{symbol}: {meaning}")).collect();
    html! {
        section {
            h2 { "Definitions" }
            @if !symbols.is_empty() { p { (symbols.join(" · ")) } }
            dl {
                @for definition in definitions {
                    @let laws: Vec<String> =
                        definition.laws.iter().map(law_text).collect();
                    dt { (breakable(definition.name)) }
                    dd {
                        (definition.how)
                        @if !laws.is_empty() { br; "Theory: " (laws.join("; or ")) }
                    }
                }
            }
        }
    }
}

/// A law with its source, range and accuracy.
fn law_text(law: &Law) -> String {
    let range =
        if law.range.is_empty() { String::new() } else { format!("; range: {}", law.range) };
    let accuracy = match law.relative_accuracy {
        0.0 => String::new(),
        accuracy => format!("; accuracy: {accuracy} of the value"),
    };
    format!("{law}{range}{accuracy}")
}

fn manifest(report: &AnalysisReport) -> Markup {
    let title = if report.runs.len() == 1 { "Manifest" } else { "Manifest of the first run" };
    html! {
        @if let Some(run) = report.runs.first() {
            section {
                h2 { (title) }
                p { (breakable(&run.file)) }
                pre { (run.manifest.canonical().trim_end()) }
            }
        }
    }
}

/// Text that may break after its dots and underscores, so that long names fit a phone; numbers stay whole.
pub(super) fn breakable(text: &str) -> Markup {
    let mut parts: Vec<(&str, bool)> = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(['_', '.']) {
        let (part, after) = rest.split_at(at + 1);
        let is_decimal_point =
            part.ends_with('.') && after.starts_with(|next: char| next.is_ascii_digit());
        parts.push((part, !is_decimal_point));
        rest = after;
    }
    html! {
        @for (part, can_break) in parts { (part) @if can_break { wbr; } }
        (rest)
    }
}

#[cfg(test)]
mod tests {
    use super::breakable;

    #[test]
    fn names_break_and_numbers_do_not() {
        let metric = "pressure.measured at temperature_k = 373.15 <";
        let broken = "pressure.<wbr>measured at temperature_<wbr>k = 373.15 &lt;";
        assert_eq!(breakable(metric).into_string(), broken);
    }
}
