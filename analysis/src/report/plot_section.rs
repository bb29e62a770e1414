//! The section of `report.html` with the plots. Each is an SVG, which the script of the page replaces by one that responds to the pointer;
//! its data is embedded once.

use super::AnalysisReport;
use super::plot_data::{ChartData, CurveRun};
use super::sweep_data::SweepData;
use crate::input::coordinates::label;
use crate::models::figures::Figures;
use crate::plot::{Chart, Curve, Plot, PlotContent, Point};
use crate::run::RunAnalysis;
use kinetoscope_console::text::{plural, visible};
use maud::{Markup, PreEscaped, html};
use serde::Serialize;
use std::borrow::Cow;

/// A plot with its SVG document.
pub(crate) struct DrawnPlot<'a> {
    /// The file name without its extension.
    pub(crate) stem: &'a str,
    pub(crate) plot: &'a Plot,
    pub(crate) svg: String,
}

/// Number of pictures that are shown openly; the replay shows the same states.
const PICTURES_SHOWN: usize = 2;

/// The plots, and for a sweep a plot of any metric over any swept key. Pictures, and the plots of runs after the first, are collapsed.
pub(super) fn section(report: &AnalysisReport, plots: &[DrawnPlot<'_>]) -> Markup {
    let sweep = SweepData::of(report);
    let (charts, pictures): (Vec<_>, Vec<_>) =
        plots.iter().partition(|drawn| matches!(drawn.plot.content, PlotContent::Chart(_)));
    let first = report.runs.iter().position(has_figures);
    let is_of_other_run = |drawn: &&DrawnPlot<'_>| {
        own_run(report, drawn)
            .is_some_and(|run| report.runs.iter().position(|it| it.file == run.file) != first)
    };
    let (others, charts): (Vec<_>, Vec<_>) = charts.into_iter().partition(is_of_other_run);
    html! {
        @if !plots.is_empty() || sweep.is_some() {
            section {
                h2 { "Plots" }
                p class="facts hint" hidden {
                    "Point at a curve for its values. Drag to zoom, double-click to reset. A legend entry hides its curve. A plot over time moves the replay."
                }
                (grid(report, &charts))
                @if let Some(sweep) = sweep { (any_metric(&sweep)) }
                @if !others.is_empty() {
                    details {
                        summary { (plural(others.len() as u64, "plot")) " of further runs" }
                        (grid(report, &others))
                    }
                }
                @if pictures.len() > PICTURES_SHOWN {
                    details {
                        summary { (pictures.len()) " pictures of states" }
                        (grid(report, &pictures))
                    }
                } @else { (grid(report, &pictures)) }
            }
        }
    }
}

fn grid(report: &AnalysisReport, plots: &[&DrawnPlot<'_>]) -> Markup {
    html! {
        @if !plots.is_empty() {
            div class="plots" {
                @for drawn in plots {
                    @let is_picture = matches!(drawn.plot.content, PlotContent::Picture(_));
                    figure id=(format!("plot-{}", drawn.stem)) class=[is_picture.then_some("picture")] {
                        (labeled_svg(&drawn.plot.title, &drawn.svg))
                        @if let PlotContent::Chart(chart) = &drawn.plot.content {
                            (data("chart", &ChartData::of(&drawn.plot.title, chart, runs_of(report, drawn, chart))))
                        }
                    }
                }
            }
        }
    }
}

/// The menus of the plot of any metric over any swept key; the script shows them.
fn any_metric(sweep: &SweepData) -> Markup {
    html! {
        div class="any" hidden {
            h3 { "Any metric against any swept key" }
            p {
                label { "metric " select class="metric" autocomplete="off" { @for name in sweep.metrics() { option { (name) } } } }
                " "
                label { "against " select class="key" autocomplete="off" { @for name in sweep.keys() { option { (name) } } } }
            }
            figure {}
            (data("sweep", sweep))
        }
    }
}

/// Data for the script. No text in it ends the element, because every `<` is escaped, and characters that are not visible are written as
/// elsewhere in the page.
fn data(class: &str, data: &impl Serialize) -> Markup {
    // The data has only numbers, texts and lists, which the serializer cannot refuse.
    let text = serde_json::to_string(data).unwrap_or_default();
    let mut json = String::with_capacity(text.len());
    for character in text.chars() {
        match visible(character.encode_utf8(&mut [0; 4])) {
            _ if character == '<' => json.push_str("\\u003c"),
            Cow::Borrowed(same) => json.push_str(same),
            Cow::Owned(escaped) => json.push_str(&escaped.replace('\\', "\\\\")),
        }
    }
    html! { script type="application/json" class=(class) { (PreEscaped(json)) } }
}

/// An SVG document of the program's own with its title as a label for screen readers.
fn labeled_svg(title: &str, svg: &str) -> Markup {
    let title = html! { (title) }.into_string();
    let opening = format!("<svg role=\"img\" aria-label=\"{title}\"");
    PreEscaped(svg.replacen("<svg", &opening, 1).trim_end().to_owned())
}

fn has_figures(run: &RunAnalysis) -> bool {
    run.figures != Figures::default()
}

/// The run whose own plot this is; `None` for a plot of several runs.
fn own_run<'a>(report: &'a AnalysisReport, drawn: &DrawnPlot<'_>) -> Option<&'a RunAnalysis> {
    let draws =
        |plot: &Plot| drawn.stem.starts_with(&plot.stem) && plot.shows_the_same_as(drawn.plot);
    report.runs.iter().find(|run| run.figures.plots.iter().any(draws))
}

/// The run behind each curve: all curves of a run's own plot are of that run, and curves of several runs are those that the runs share.
/// Curves of a sweep are of no single run.
fn runs_of(report: &AnalysisReport, drawn: &DrawnPlot<'_>, chart: &Chart) -> Vec<Option<CurveRun>> {
    let own = own_run(report, drawn);
    let of_curve = |points: &[Point]| {
        let shares = |run: &&RunAnalysis| {
            let is_shared = run.figures.comparisons.iter().any(|curve| {
                drawn.stem.starts_with(&curve.stem) && curve.points.as_slice() == points
            });
            is_shared
                || run
                    .fields
                    .iter()
                    .any(|field| Curve::line("", 0, field.points.iter().copied()).points == points)
        };
        own.or_else(|| report.runs.iter().find(shares))
    };
    chart.curves.iter().map(|curve| of_curve(&curve.points).map(named)).collect()
}

fn named(run: &RunAnalysis) -> CurveRun {
    let name = match label(&run.coordinates) {
        name if name.is_empty() => run.file.clone(),
        name => name,
    };
    CurveRun { file: run.file.clone(), name }
}

#[cfg(test)]
mod tests {
    use super::data;

    #[test]
    fn no_text_ends_the_element_of_the_data() {
        let markup = data("chart", &["</script><script>alert(1)</script>", "a & \"b\" \u{202e}"]);
        let text = markup.into_string();
        assert_eq!(text.matches("</script>").count(), 1, "{text}");
        assert!(text.contains("\\u003c/script>") && text.contains("a & \\\"b\\\""), "{text}");
        assert!(!text.contains('\u{202e}') && text.contains("202e"), "{text}");
    }
}
