//! `report.html`: one file that needs nothing else, for a wide screen, a phone and paper, light or dark.

use crate::checks::CheckKind;
use crate::checks::ci_formats::escaped;
use crate::input::coordinates::label;
use crate::metric::Metric;
use crate::report::AnalysisReport;
use crate::report::table::{deviation_text, six_digits, with_error};
use kinetoscope_manifest::{Coordinate, TimingTable};
use std::collections::BTreeSet;
use std::fmt::Write as _;

const STYLE: &str = include_str!("report.css");

/// The page. `plots` are titles and SVG documents, in order.
#[must_use]
pub fn page(report: &AnalysisReport, plots: &[(&str, String)]) -> String {
    let name = escaped(&report.name);
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n"
    );
    text += &heading(report);
    text += &remarks(report);
    text += &verdicts(report);
    text += &figures(plots);
    text += &report.timing.as_ref().map_or_else(String::new, timing);
    text += &numbers(report);
    text += &definitions(report);
    text += &manifest(report);
    text + "</main>\n</body>\n</html>\n"
}

fn heading(report: &AnalysisReport) -> String {
    let runs = report.runs.len();
    let runs = if runs == 1 { "1 run".to_owned() } else { format!("{runs} runs") };
    let failed = report.check_results.iter().filter(|verdict| !verdict.passed).count();
    let (tone, verdict) = match (report.check_results.len(), failed) {
        (0, _) => ("", "no checks".to_owned()),
        (1, 0) => ("good", "the check holds".to_owned()),
        (all, 0) => ("good", format!("all {all} checks hold")),
        (all, failed) => ("bad", format!("{failed} of {all} checks failed")),
    };
    format!(
        "<header>\n<h1>{}</h1>\n<p>{}</p>\n<p class=\"facts\">{} · {runs} · <strong class=\"{tone}\">{verdict}</strong></p>\n</header>\n",
        breakable(&report.name),
        escaped(&report.description),
        escaped(report.model()),
    )
}

/// Notes, and what could not be read.
fn remarks(report: &AnalysisReport) -> String {
    let mut text = String::new();
    for (title, tone, lines) in
        [("Unreadable", "bad", &report.unreadable), ("Notes", "", &report.notes)]
    {
        if !lines.is_empty() {
            // Writing to a String can't fail.
            let _ = writeln!(text, "<section>\n<h2 class=\"{tone}\">{title}</h2>\n<ul>");
            for line in lines {
                let _ = writeln!(text, "<li>{}</li>", escaped(line));
            }
            text += "</ul>\n</section>\n";
        }
    }
    text
}

fn verdicts(report: &AnalysisReport) -> String {
    let mut text = String::new();
    for (judge, title) in
        [(CheckKind::Check, "Checks"), (CheckKind::Baseline, "Against the baseline")]
    {
        let of: Vec<_> =
            report.check_results.iter().filter(|verdict| verdict.kind == judge).collect();
        if of.is_empty() {
            continue;
        }
        let _ = writeln!(
            text,
            "<section>\n<h2>{title}</h2>\n<table class=\"verdicts\">\n<thead><tr><th></th><th>metric</th><th>finding</th></tr></thead>\n<tbody>"
        );
        for verdict in of {
            let (tone, word) = if verdict.passed { ("good", "ok") } else { ("bad", "failed") };
            let _ = writeln!(
                text,
                "<tr><td><strong class=\"{tone}\">{word}</strong></td><td>{}</td><td>{}</td></tr>",
                breakable(&verdict.subject),
                escaped(&verdict.finding)
            );
        }
        text += "</tbody>\n</table>\n</section>\n";
    }
    text
}

fn figures(plots: &[(&str, String)]) -> String {
    if plots.is_empty() {
        return String::new();
    }
    let mut text = "<section>\n<h2>Plots</h2>\n<div class=\"plots\">\n".to_owned();
    for (title, svg) in plots {
        let named = format!("<svg role=\"img\" aria-label=\"{}\"", escaped(title));
        let svg = svg.replacen("<svg", &named, 1);
        let _ = writeln!(text, "<figure>{}</figure>", svg.trim_end());
    }
    text + "</div>\n</section>\n"
}

fn numbers(report: &AnalysisReport) -> String {
    let mut text = "<section>\n<h2>Numbers</h2>\n\
        <p>Digits in brackets are one standard error, in units of the last digits. σ is the deviation from theory in standard errors.</p>\n"
        .to_owned();
    for (title, metrics) in report.sections() {
        let _ = writeln!(text, "<h3>{}</h3>", breakable(&title));
        if metrics.is_empty() {
            continue;
        }
        text += "<table class=\"numbers\">\n<thead><tr><th>metric</th><th>value</th><th>unit</th><th>theory</th><th>apart</th></tr></thead>\n<tbody>\n";
        for metric in metrics {
            text += &number(metric);
        }
        text += "</tbody>\n</table>\n";
    }
    text + "</section>\n"
}

/// How long the runs took, of which no metric knows.
fn timing(table: &TimingTable) -> String {
    let mut text = format!(
        "<section>\n<h2>Timing</h2>\n<p>The engine alone, one run at a time, nothing recorded, {}. \
         These figures belong to that machine.</p>\n<table class=\"numbers\">\n<thead><tr><th>point (runs)</th><th>mean/s</th>\
         <th>standard deviation/s</th><th>median/s</th><th>steps or events/s</th></tr></thead>\n<tbody>\n",
        escaped(&table.machine)
    );
    let labeled =
        |label: &str, value: String| format!("<td data-label=\"{label}\">{}</td>", escaped(&value));
    let named = |coordinates: &[Coordinate]| match label(coordinates) {
        place if place.is_empty() => "all".to_owned(),
        place => place,
    };
    for point in &table.points {
        let place = format!("{} ({})", named(&point.coordinates), point.runs);
        let _ = writeln!(
            text,
            "<tr><td>{}</td>{}{}{}{}</tr>",
            breakable(&place),
            labeled("mean/s", four_digits(point.mean_s)),
            labeled("deviation/s", four_digits(point.standard_deviation_s)),
            labeled("median/s", four_digits(point.median_s)),
            labeled("per second", four_digits(point.steps_or_events_per_s)),
        );
    }
    text += "</tbody>\n</table>\n";
    if let Some(comparison) = &table.comparison {
        let _ = writeln!(
            text,
            "<h3>Time of {} over time of {}</h3>\n<table class=\"numbers\">\n<thead><tr><th>point</th><th>geometric mean</th>\
             <th>median</th></tr></thead>\n<tbody>",
            escaped(&comparison.of),
            escaped(&comparison.over)
        );
        for ratio in comparison.ratios.iter().chain([&comparison.all]) {
            let _ = writeln!(
                text,
                "<tr><td>{}</td>{}{}</tr>",
                breakable(&named(&ratio.coordinates)),
                labeled("mean", with_error(ratio.mean, Some(ratio.standard_error))),
                labeled("median", four_digits(ratio.median)),
            );
        }
        text += "</tbody>\n</table>\n";
    }
    text + "</section>\n"
}

/// A positive number in four digits.
fn four_digits(value: f64) -> String {
    let unit = 10.0_f64.powf(value.log10().floor() - 3.0);
    six_digits(if value > 0.0 { (value / unit).round() * unit } else { value })
}

fn number(metric: &Metric) -> String {
    let unit = if metric.unit() == "1" { "" } else { metric.unit() };
    let theory = metric.theory.map_or_else(String::new, six_digits);
    let labeled = |label: &str, text: &str| {
        let label = if text.is_empty() { "" } else { label };
        format!("<td data-label=\"{label}\">{}</td>", escaped(text))
    };
    format!(
        "<tr><td>{}</td>{}{}{}{}</tr>\n",
        breakable(metric.name()),
        labeled("", &with_error(metric.value, metric.standard_error)),
        labeled("", unit),
        labeled("theory", &theory),
        labeled("apart", &deviation_text(metric)),
    )
}

/// How each metric of this report is found, and the laws behind theory's values.
fn definitions(report: &AnalysisReport) -> String {
    let mut text = "<section>\n<h2>Definitions</h2>\n<dl>\n".to_owned();
    let mut told = BTreeSet::new();
    let all = report.metrics.iter().map(|metric| metric.definition);
    for definition in all.filter(|definition| told.insert((definition.name, definition.how))) {
        let laws: Vec<String> =
            definition.laws.iter().map(|law| escaped(&law.to_string())).collect();
        let laws = if laws.is_empty() {
            String::new()
        } else {
            format!("<br>Theory: {}", laws.join("; or "))
        };
        let _ = writeln!(
            text,
            "<dt>{}</dt><dd>{}{laws}</dd>",
            breakable(definition.name),
            escaped(definition.how)
        );
    }
    text + "</dl>\n</section>\n"
}

fn manifest(report: &AnalysisReport) -> String {
    let Some(run) = report.runs.first() else { return String::new() };
    let title = if report.runs.len() == 1 { "Manifest" } else { "Manifest of the first run" };
    format!(
        "<section>\n<h2>{title}</h2>\n<p>{}</p>\n<pre>{}</pre>\n</section>\n",
        breakable(&run.file),
        escaped(run.manifest.canonical().trim_end())
    )
}

/// Text that may break after its dots and underscores, so that long names fit a phone; numbers stay whole.
fn breakable(text: &str) -> String {
    let mut broken = String::new();
    let mut rest = escaped(text);
    while let Some(at) = rest.find(['_', '.']) {
        let after = rest.split_off(at + 1);
        broken += &rest;
        let is_point = rest.ends_with('.') && after.starts_with(|next: char| next.is_ascii_digit());
        if !is_point {
            broken += "<wbr>";
        }
        rest = after;
    }
    broken + &rest
}

#[cfg(test)]
mod tests {
    use super::breakable;

    #[test]
    fn names_break_and_numbers_do_not() {
        let metric = "pressure.measured at temperature_k = 373.15";
        let broken = "pressure.<wbr>measured at temperature_<wbr>k = 373.15";
        assert_eq!(breakable(metric), broken);
    }
}
