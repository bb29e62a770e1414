//! The section of `report.html` with the plots. Each is an SVG, which the script of the page replaces by one that responds to the pointer;
//! its data is embedded once.

use super::AnalysisReport;
use super::plot_data::{ChartData, CurveRun};
use super::sweep_data::SweepData;
use crate::checks::{CheckKind, subject};
use crate::input::coordinates::{file_part, label};
use crate::plot::{Chart, Curve, Plot, PlotContent, Point};
use crate::run::RunAnalysis;
use kinetoscope_console::text::visible;
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

/// Maximum number of plots next to the replay; further requested ones are below.
const MOST_ADJACENT: usize = 2;

/// The plots in the order of the page.
pub(super) struct SortedPlots<'a> {
    /// Those that answer the question, next to the replay.
    adjacent: Vec<&'a DrawnPlot<'a>>,
    /// Further requested ones.
    requested: Vec<&'a DrawnPlot<'a>>,
    /// All others: charts, and pictures of states of runs without a replay.
    charts: Vec<&'a DrawnPlot<'a>>,
    pictures: Vec<&'a DrawnPlot<'a>>,
}

impl<'a> SortedPlots<'a> {
    pub(super) fn of(report: &AnalysisReport, plots: &'a [DrawnPlot<'a>]) -> Self {
        let is_chart = |drawn: &&DrawnPlot<'_>| matches!(drawn.plot.content, PlotContent::Chart(_));
        let (charts, mut pictures): (Vec<_>, Vec<_>) = plots.iter().partition(is_chart);
        // The replay shows the same; the files next to the page have them.
        let plays =
            |run: &RunAnalysis| run.replay.as_ref().is_some_and(|replay| replay.film.is_some());
        pictures.retain(|drawn| !own_run(report, drawn).is_some_and(plays));
        let is_requested = |drawn: &&DrawnPlot<'_>| report.is_requested_plot(drawn.stem);
        let (mut requested, mut charts): (Vec<_>, Vec<_>) =
            charts.into_iter().partition(is_requested);
        if requested.is_empty()
            && let Some(place) = answering(report, &charts)
        {
            requested.push(charts.remove(place));
        }
        let further = requested.split_off(requested.len().min(MOST_ADJACENT));
        Self { adjacent: requested, requested: further, charts, pictures }
    }

    /// The figures next to the replay; empty if there are none.
    pub(super) fn adjacent(&self, report: &AnalysisReport) -> Markup {
        html! { @for drawn in &self.adjacent { (figure(report, drawn)) } }
    }

    /// The other requested plots.
    pub(super) fn requested(&self, report: &AnalysisReport) -> Markup {
        html! { @if !self.requested.is_empty() { section { (grid(report, &self.requested)) } } }
    }

    /// All other plots, and for a sweep a plot of any metric over any swept key; collapsed.
    pub(super) fn others(&self, report: &AnalysisReport) -> Markup {
        let sweep = SweepData::of(report);
        html! {
            @if !self.charts.is_empty() {
                details class="printed" {
                    summary { h2 { "More plots" } " " span class="facts" { (self.charts.len()) } }
                    p class="facts hint" hidden {
                        "Point at a curve for its values. Drag to zoom, double-click to reset. A legend entry hides its curve. A plot over time moves the replay."
                    }
                    (grid(report, &self.charts))
                }
            }
            @if let Some(sweep) = sweep {
                details {
                    summary { h2 { "Any metric against any swept key" } }
                    (any_metric(&sweep))
                }
            }
            @if !self.pictures.is_empty() {
                details {
                    summary { h2 { "Pictures of states" } " " span class="facts" { (self.pictures.len()) } }
                    (grid(report, &self.pictures))
                }
            }
        }
    }
}

/// The chart that comes closest to an answer where none is requested: of the first checked metric over the sweep, else the first one over time, else
/// the first one.
fn answering(report: &AnalysisReport, charts: &[&DrawnPlot<'_>]) -> Option<usize> {
    let checked = report.check_results.iter().filter(|result| result.kind == CheckKind::Check);
    let mut checked = checked.filter_map(|result| {
        let metric = report.metrics.iter().find(|metric| subject(metric) == result.subject)?;
        let stem = metric.name().replace('.', "_");
        let is_of = |drawn: &&DrawnPlot<'_>| drawn.stem.starts_with(&stem);
        charts.iter().position(is_of).filter(|_| !metric.is_of_conservation_law())
    });
    let is_over_time = |drawn: &&DrawnPlot<'_>| match &drawn.plot.content {
        PlotContent::Chart(chart) => chart.x.label == "time",
        PlotContent::Picture(_) => false,
    };
    let over_time = || charts.iter().position(is_over_time);
    checked.next().or_else(over_time).or((!charts.is_empty()).then_some(0))
}

fn grid(report: &AnalysisReport, plots: &[&DrawnPlot<'_>]) -> Markup {
    html! { div class="plots" { @for drawn in plots { (figure(report, drawn)) } } }
}

fn figure(report: &AnalysisReport, drawn: &DrawnPlot<'_>) -> Markup {
    let is_picture = matches!(drawn.plot.content, PlotContent::Picture(_));
    html! {
        figure id=(format!("plot-{}", drawn.stem)) class=[is_picture.then_some("picture")] {
            (labeled_svg(&drawn.plot.title, &drawn.svg))
            @if let PlotContent::Chart(chart) = &drawn.plot.content {
                (data("chart", &ChartData::of(&drawn.plot.title, chart, runs_of(report, drawn, chart))))
            }
        }
    }
}

/// The menus of the plot of any metric over any swept key; the script shows them.
fn any_metric(sweep: &SweepData) -> Markup {
    html! {
        div class="any" hidden {
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
pub(super) fn data(class: &str, data: &impl Serialize) -> Markup {
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

/// An SVG document of the program's own with its title as a label for screen readers, without attributes that the page gives all of them.
fn labeled_svg(title: &str, svg: &str) -> Markup {
    let title = html! { (title) }.into_string();
    let opening = format!("<svg role=\"img\" aria-label=\"{title}\"");
    let svg = svg.replace(" opacity=\"1\"", "").replace(" font-family=\"sans-serif\"", "");
    PreEscaped(svg.replacen("<svg", &opening, 1).trim_end().to_owned())
}

/// The run whose own plot this is; `None` for a plot of several runs.
fn own_run<'a>(report: &'a AnalysisReport, drawn: &DrawnPlot<'_>) -> Option<&'a RunAnalysis> {
    let draws =
        |plot: &Plot| drawn.stem.starts_with(&plot.stem) && plot.shows_the_same_as(drawn.plot);
    // Two runs may have equal points: then the name of the plot decides.
    let is_named = |run: &&RunAnalysis| {
        let place = file_part(&run.coordinates);
        run.figures.plots.iter().any(|plot| drawn.stem == plot.stem.clone() + &place && draws(plot))
    };
    let mut runs = report.runs.iter();
    runs.clone().find(is_named).or_else(|| runs.find(|run| run.figures.plots.iter().any(draws)))
}

/// The run behind each curve: all curves of a run's own plot are of that run, and curves of several runs are those that the runs share.
/// Curves of a sweep are of no single run.
fn runs_of(report: &AnalysisReport, drawn: &DrawnPlot<'_>, chart: &Chart) -> Vec<Option<CurveRun>> {
    let own = own_run(report, drawn);
    let of_curve = |name: &str, points: &[Point]| {
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
        // Two runs may have equal points: then the name of the curve decides.
        let by_name = |run: &&RunAnalysis| label(&run.coordinates) == name && shares(run);
        let runs = || report.runs.iter();
        own.or_else(|| runs().find(by_name)).or_else(|| runs().find(shares))
    };
    chart.curves.iter().map(|curve| of_curve(&curve.name, &curve.points).map(named)).collect()
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
