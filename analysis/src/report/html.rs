//! `report.html`: one self-contained file for a wide screen, a phone and paper, in light or dark.
//!
//! Text is escaped by the type [`Markup`], and control and bidirectional characters in the whole page; only the style sheet, the script, the SVG documents
//! and the data of replays in base64 are inserted as they are.

use super::file_links::FileLinks;
use super::markup::{breakable, typographic};
use super::plot_section::{DrawnPlot, SortedPlots};
use super::{
    AnalysisReport, engine, head, numbers, provenance, replay_section, timing_section, verify,
};
use crate::checks::baseline::BaselineComparison;
use crate::checks::{CheckKind, CheckResult};
use crate::number_text::six_digits;
use crate::plot::palette;
use crate::replay::Film;
use kinetoscope_console::text::visible;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE_SHEET: &str = include_str!("report.css");
/// The parts of the script, in the order in which they use each other.
const SCRIPTS: [&str; 8] = [
    include_str!("numbers.js"),
    include_str!("film.js"),
    include_str!("pictures.js"),
    TRAILS,
    include_str!("replay.js"),
    include_str!("deck.js"),
    include_str!("report.js"),
    include_str!("distributions.js"),
];

const TRAILS: &str = include_str!("trails.js");
/// What stands in place of it where discs, which have no trails, fly as recorded, and the end of the lines for these pages only.
const FLIGHTS: &str = include_str!("flights.js");
const FOR_FLIGHTS: &str = " // flights";

/// The script as a page contains it: without indentation, lines of comments and the spaces next to punctuation. No text in it spans lines.
fn script(has_flights: bool) -> String {
    let parts = SCRIPTS.map(|part| if has_flights && part == TRAILS { FLIGHTS } else { part });
    let lines = parts
        .iter()
        .flat_map(|part| part.lines())
        .map(str::trim_start)
        .filter(|line| !line.starts_with("//") && (has_flights || !line.ends_with(FOR_FLIGHTS)))
        .map(|line| line.strip_suffix(FOR_FLIGHTS).unwrap_or(line));
    lines.map(squeezed).collect::<Vec<_>>().join("\n")
}

/// A line without the spaces next to punctuation outside of texts, unless it has a template, a regular expression or a division.
fn squeezed(line: &str) -> String {
    if line.contains(['\'', '`', '/', '\\']) {
        return line.to_owned();
    }
    let parts = line.split('"').enumerate();
    let parts = parts
        .map(|(index, part)| if index % 2 == 0 { squeezed_code(part) } else { part.to_owned() });
    parts.collect::<Vec<_>>().join("\"")
}

fn squeezed_code(code: &str) -> String {
    let letters: Vec<char> = code.chars().collect();
    let is_punctuation = |letter: &char| ",;{}()[]=><?:&|*%+".contains(*letter);
    let is_needed = |place: usize| {
        let neighbors = letters[place.saturating_sub(1)..].iter().take(3);
        letters[place] != ' ' || !neighbors.into_iter().any(is_punctuation)
    };
    (0..letters.len()).filter(|place| is_needed(*place)).map(|place| letters[place]).collect()
}

/// The head of a page with a style sheet in addition to the common one, and what the page may load.
pub(super) fn page_head(title: &str, style_sheet: &str, policy: &Markup) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            (policy)
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta name="color-scheme" content="light dark";
            // Without one, a browser asks the server for a file.
            link rel="icon" href="data:,";
            title { (title) }
            style { (PreEscaped(STYLE_SHEET)) (PreEscaped(style_sheet)) }
        }
    }
}

/// The page with its plots, in order, and the files next to it.
pub(crate) fn page(report: &AnalysisReport, plots: &[DrawnPlot<'_>], links: &FileLinks) -> String {
    let outcomes = report.check_results.iter().filter(|result| result.kind == CheckKind::Outcome);
    let outcomes: Vec<&CheckResult> = outcomes.collect();
    let unreadable = report.unreadable.iter().map(|why| why.message.clause());
    let unreadable: Vec<String> = unreadable.collect();
    let sorted = SortedPlots::of(report, plots);
    let background = head::background(report);
    let films = || report.runs.iter().filter_map(|run| run.replay.as_ref()?.film.as_ref());
    let has_flights = films().any(Film::has_flights) && !films().any(|film| film.has_trails);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (page_head(&report.name, &palette::style_sheet(), &engine::policy(report.engine)))
            body {
                main {
                    (heading(report))
                    (replay_section::section(report, &sorted.adjacent(report)))
                    (remarks("Unreadable", "bad", &unreadable))
                    @if report.headline().is_some() { (check_table(&outcomes, "Outcomes")) }
                    @if let Some(table) = &report.timing { (timing_section::section(table)) }
                    (numbers::checked(report))
                    @if let Some(comparison) = &report.baseline { (baseline(comparison)) }
                    (sorted.requested(report))
                    (verify::section(report))
                    div class="folds" {
                        @if !background.0.is_empty() {
                            details {
                                summary { h2 { "Expectation and setup" } }
                                (background)
                            }
                        }
                        (sorted.others(report))
                        (numbers::section(report))
                        (numbers::definitions(report))
                        (folded_remarks(&report.notes))
                        (replay_section::left_out(report))
                        (manifest(report))
                        (provenance::section(report, links))
                    }
                }
                script nonce=(engine::NONCE) { (PreEscaped(script(has_flights))) }
            }
        }
    };
    visible(&(page.into_string() + "\n")).into_owned()
}

/// The question, the result, and, in small letters, the name and whether the checks pass.
fn heading(report: &AnalysisReport) -> Markup {
    let (class, summary) = head::checks_summary(report);
    html! {
        header {
            (head::title(report))
            @if let Some(headline) = report.headline() {
                p { strong class="bad" { "FAILED: " (headline) } }
            }
            @if let Some(unreadable) = report.unreadable_files() {
                p { strong class="bad" { (unreadable) } }
            }
            (head::result(report, ""))
            div class="kicker" {
                @if !summary.is_empty() { strong class=(class) { (summary) (head::what_is_checked(report)) } }
                span class="facts" {
                    @if !report.question.is_empty() { (breakable(&report.name)) " · " }
                    (report.models_and_runs())
                }
            }
        }
    }
}

/// A collapsed list of notes; nothing for an empty list.
fn folded_remarks(lines: &[String]) -> Markup {
    html! {
        @if !lines.is_empty() {
            details {
                summary { h2 { "Notes" } " " span class="facts" { (lines.len()) } }
                ul { @for line in lines { li { (line) } } }
            }
        }
    }
}

/// A list of what could not be read; nothing for an empty list.
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

fn check_table(results: &[&CheckResult], title: &str) -> Markup {
    html! {
        @if !results.is_empty() {
            section {
                h2 { (title) }
                (check_rows(results))
            }
        }
    }
}

fn check_rows(results: &[&CheckResult]) -> Markup {
    html! {
        table class="checks" {
            thead { tr { th { "result" } th { "metric" } th { "finding" } } }
            tbody {
                @for result in results {
                    @let (class, word) =
                        if result.passed { ("good", "ok") } else { ("bad", "failed") };
                    tr {
                        td { strong class=(class) { (word) } }
                        td { (breakable(&result.subject)) }
                        td { (typographic(&result.finding)) }
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
            @for line in comparison.sensitivity_lines() { p { (line) } }
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

fn manifest(report: &AnalysisReport) -> Markup {
    let title = if report.runs.len() == 1 { "Manifest" } else { "Manifest of the first run" };
    html! {
        @if let Some(run) = report.runs.first() {
            details {
                summary { h2 { (title) } }
                p { (breakable(&run.file)) }
                pre data-file=(run.file) { (run.manifest.canonical().trim_end()) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{FLIGHTS, SCRIPTS, STYLE_SHEET, script};

    #[test]
    fn script_and_style_are_small() {
        let is_whole = |line: &str| line.matches('`').count().is_multiple_of(2);
        assert!(
            SCRIPTS.iter().chain([&FLIGHTS]).flat_map(|part| part.lines()).all(is_whole),
            "a text that spans lines would lose its indentation"
        );
        assert!(SCRIPTS.iter().all(|part| !part.contains("+ +")), "two signs would become one");
        let [script, in_flight] = [false, true].map(script);
        for (text, most) in [(&*script, 60_000), (&*in_flight, 60_000), (STYLE_SHEET, 12_000)] {
            assert!(text.len() <= most, "{} of {most} bytes", text.len());
            // The ends of the elements that contain them.
            assert!(!text.contains("</script") && !text.contains("</style"));
        }
    }

    /// Guarantee: a page printed from a dark theme has no color of it left.
    #[test]
    fn paper_has_every_color_of_its_own() {
        let colors = |media: &str| -> Vec<&str> {
            let (_, block) = STYLE_SHEET.split_once(media).unwrap();
            let block = block.split_once(":root {").unwrap().1.split('}').next().unwrap();
            block.split(';').filter_map(|line| Some(line.split_once(':')?.0.trim())).collect()
        };
        let on_paper = colors("@media print");
        for color in colors("@media (prefers-color-scheme: dark)") {
            assert!(on_paper.contains(&color), "{color}");
        }
    }
}
