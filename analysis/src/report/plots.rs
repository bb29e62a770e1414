//! The plots of a report with their file names: those on request, of the sweep, of several runs, and of single runs.

use super::MAX_RUNS_DRAWN;
use crate::answer::Answer;
use crate::input::coordinates;
use crate::models::figures::Figures;
use crate::models::{figure_names, main_results, metrics_of_figure};
use crate::plot::{Plot, PlotContent};
use crate::run::RunAnalysis;
use crate::sweep;
use crate::sweep::requested::PlotData;
use kinetoscope_manifest::{ExperimentRecord, PlotRequest};

/// The plots that the manifest requests, in its order. A sweep over a number without an answer or plots of its own whose requests show no metric has
/// one of the metric that the answer names first: in front, or behind a first request that has a title of its own, which the author
/// has chosen for the question. Without requests, the chart of the answer follows.
pub(super) fn requests(
    record: Option<&ExperimentRecord>,
    answer: &Answer,
    data: PlotData<'_>,
) -> Vec<PlotRequest> {
    let stated = record.map_or(&[][..], |record| &record.plots);
    let shows_metric = |plot: &PlotRequest| !plot.y.is_empty() && !plot.is_of_channel();
    let is_answered = record.is_none_or(|record| record.answer.is_some());
    let is_wanted = (!is_answered || stated.is_empty())
        && data.points.len() > 1
        && !stated.iter().any(shows_metric);
    let composed = answer
        .metrics()
        .next()
        .filter(|_| is_wanted)
        .map(|y| PlotRequest { y: y.to_owned(), ..PlotRequest::default() })
        .filter(|request| data.draw(request).is_ok_and(|plot| is_over_number(&plot)));
    let most = MOST_CHARTS - usize::from(composed.is_some());
    let charts = if stated.is_empty() { charts_of_answer(answer, data, most) } else { Vec::new() };
    let is_titled = stated.first().is_some_and(|first| first.title.is_some());
    let (before, after) = stated.split_at(usize::from(is_titled));
    before.iter().cloned().chain(composed).chain(after.iter().cloned()).chain(charts).collect()
}

/// The chart that the replay next to it shows as well.
const REPLAYED: &str = "path";
/// Maximum number of plots of an answer, which have room next to the replay.
const MOST_CHARTS: usize = 2;

/// The charts of the model that show a main result in the answer, or else another number in it, or else a main result; of several runs those that they
/// share. After the first one, a chart has a number of the answer that those before it do not show.
fn charts_of_answer(answer: &Answer, data: PlotData<'_>, most: usize) -> Vec<PlotRequest> {
    let Some(model) = data.runs.first().map(RunAnalysis::model) else { return Vec::new() };
    let main = main_results(model);
    let (of_main, others): (Vec<&str>, Vec<&str>) =
        answer.metrics().partition(|metric| main.metrics.contains(metric));
    let all = figure_names(model.name());
    let shows = |stem: &str, metric: &str| metrics_of_figure(model.name(), stem).contains(&metric);
    let showing = of_main
        .iter()
        .chain(&others)
        .flat_map(|metric| main.charts.iter().chain(&all).filter(move |stem| shows(stem, metric)));
    let mut stems: Vec<&str> = showing.chain(main.charts).copied().collect();
    if data.points.len() > 1 {
        stems.sort_by_key(|stem| !stem.ends_with(OF_SEVERAL_RUNS));
    }
    let request =
        |stem: &str| PlotRequest { figure: Some(stem.to_owned()), ..PlotRequest::default() };
    let is_drawn = |stem: &&str| data.draw(&request(stem)).is_ok_and(|it| it.is_informative());
    let mut drawn: Vec<&str> = Vec::new();
    for stem in stems {
        let is_new =
            |metric: &&str| shows(stem, metric) && !drawn.iter().any(|it| shows(it, metric));
        let adds =
            drawn.is_empty() || stem != REPLAYED && of_main.iter().chain(&others).any(is_new);
        if drawn.len() < most && adds && is_drawn(&stem) {
            drawn.push(stem);
        }
    }
    drawn.into_iter().map(request).collect()
}

/// How the names of charts end that several runs share.
const OF_SEVERAL_RUNS: &str = "_by_run";

fn is_over_number(plot: &Plot) -> bool {
    matches!(&plot.content, PlotContent::Chart(chart) if chart.x.words.is_empty())
}

/// All plots, those on request first, and the number of the latter. Other plots without information are omitted. A request adds a
/// note if it cannot be drawn, or if points of it cannot.
pub(super) fn plots(
    data: PlotData<'_>,
    requests: &[PlotRequest],
    notes: &mut Vec<String>,
) -> (Vec<(String, Plot)>, usize) {
    let PlotData { runs, points, .. } = data;
    let mut requested: Vec<Plot> = Vec::new();
    for request in requests {
        match data.draw(request) {
            Ok(plot) => {
                let hidden = plot.hidden_data();
                notes.extend(hidden.map(|hidden| format!("plot of `{}`: {hidden}", request.y)));
                requested.push(plot);
            }
            Err(why) => {
                notes.push(format!(
                    "the plot of `{}` was not drawn: {}",
                    request.subject(),
                    why.clause()
                ));
            }
        }
    }
    let mut others = sweep::figures::plots(points);
    // The same quantities in the layout that was requested are not drawn again.
    others.retain(|plot| requested.iter().all(|other| other.stem != plot.stem));
    let drawn: Vec<&RunAnalysis> =
        runs.iter().filter(|run| run.figures != Figures::default()).collect();
    others.extend(sweep::figures::comparisons(&drawn));
    for run in drawn.iter().take(MAX_RUNS_DRAWN) {
        others.extend(run.figures.plots.iter().map(|plot| named(plot, run)));
    }
    if drawn.len() > MAX_RUNS_DRAWN {
        notes.push(format!(
            "the first {MAX_RUNS_DRAWN} drawn points of the sweep have plots of their own; plots of several runs show at most {} points, from the first to the last",
            sweep::figures::MAX_CURVES
        ));
    }
    others.retain(Plot::is_informative);
    others.retain(|plot| !requested.iter().any(|other| other.shows_the_same_as(plot)));
    let on_request = requested.len();
    requested.append(&mut others);
    (uniquely_named(requested), on_request)
}

/// The plot of one run, named by its place in the sweep.
fn named(plot: &Plot, run: &RunAnalysis) -> Plot {
    let label = coordinates::label(&run.coordinates);
    let mut plot = plot.clone();
    plot.stem += &coordinates::file_part(&run.coordinates);
    if !label.is_empty() {
        plot.title = format!("{}: {label}", plot.title);
    }
    plot
}

/// The plots with the names of their files; of equal names, later ones are numbered.
fn uniquely_named(plots: Vec<Plot>) -> Vec<(String, Plot)> {
    let mut named: Vec<(String, Plot)> = Vec::new();
    for plot in plots {
        let mut name = plot.stem.clone();
        let mut number = 2;
        while named.iter().any(|(other, _)| *other == name) {
            name = format!("{}_{number}", plot.stem);
            number += 1;
        }
        named.push((name, plot));
    }
    named
}
