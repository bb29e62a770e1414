//! Guarantee: every shipped experiment plots a quantity that one of its checks or its answer uses, and the areas of an energy balance
//! fill the energy that the run was given, up to the recorded residual.

use crate::subcommand_bench::{Bench, call};
use kinetoscope_analysis::{figure_names, fitted_along, metric_names, metrics_of_figure, unit_of};
use kinetoscope_manifest::{Experiment, Lookup, PlotRequest, channel_field, parse_with};
use std::fs;
use std::path::PathBuf;

/// The manifests of `experiments/` with their texts.
fn shipped() -> Vec<(PathBuf, String, Experiment)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    files.sort();
    let lookup = Lookup {
        recordings: None,
        metrics: Some(metric_names),
        figures: Some(figure_names),
        fitted_along: Some(fitted_along),
        unit_of: Some(unit_of),
    };
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).unwrap();
        let experiment = parse_with(&text, &path.to_string_lossy(), &[], lookup)
            .unwrap_or_else(|errors| panic!("{errors}"));
        (path, text, experiment)
    };
    files.into_iter().map(read).collect()
}

/// The line of a metric in the reference of all metrics.
fn reference(metric: &str, reference: &str) -> String {
    let start = format!("| `{metric}` |");
    reference.lines().filter(|line| line.starts_with(&start)).collect::<Vec<_>>().join("\n")
}

/// Whether a plot shows a metric: the metric itself, what it is derived from, or a chart that shows it.
fn shows(plot: &PlotRequest, model: &str, metric: &str, all: &str) -> bool {
    if let Some(figure) = &plot.figure {
        return metrics_of_figure(model, figure).contains(&metric);
    }
    let derived = reference(metric, all);
    plot.ordinates().any(|name| match channel_field(name) {
        Some((topic, _)) => derived.contains(topic),
        None => name == metric || derived.contains(name),
    })
}

/// Source of what a metric is derived from: the reference that the program prints. `packing_timing_table` asks for the time of the
/// computer, which no metric contains.
#[test]
fn shipped_experiments_plot_what_they_check() {
    let all = call(["analyze", "--list-metrics"]).out;
    let mut titled = 0;
    for (path, text, experiment) in shipped() {
        let model = experiment.runs[0].manifest.model.name();
        let answer = text.lines().find(|line| line.starts_with("answer = ")).unwrap_or_default();
        let in_answer = metric_names(model);
        let in_answer =
            in_answer.iter().filter(|name| answer.contains(&format!("{{{name}"))).copied();
        let checked: Vec<&str> =
            experiment.checks.iter().map(|check| check.metric.as_str()).chain(in_answer).collect();
        let is_shown = |plot| checked.iter().any(|metric| shows(plot, model, metric, &all));
        let is_timing = path.ends_with("packing_timing_table.toml");
        assert!(!experiment.plots.is_empty(), "{}", path.display());
        assert!(is_timing || experiment.plots.iter().any(is_shown), "{}", path.display());
        titled += usize::from(experiment.plots.iter().all(|plot| plot.title.is_some()));
    }
    assert!(titled >= 51, "{titled} experiments have titled plots");
    let height =
        PlotRequest { figure: Some("packing_by_height".to_owned()), ..PlotRequest::default() };
    assert!(shows(&height, "dem", "bed.height", &all));
    assert!(!shows(&height, "dem", "energy.wall_work", &all), "control");
}

/// The ordinates of a curve.
fn points(curve: &serde_json::Value) -> Vec<f64> {
    let points = curve["points"].as_array().unwrap().iter();
    points.map(|point| point["y"].as_f64().unwrap()).collect()
}

/// Setup: the first run of each shipped DEM experiment for a quarter of its duration, or less for many discs. Tolerance: the numbers of a message have 16
/// digits. Control: without the work of the walls, the drum's areas exceed their sum.
#[test]
fn areas_of_the_energy_balance_fill_what_the_run_was_given() {
    let (mut kinds, mut runs) = (Vec::new(), 0);
    for (path, _, experiment) in shipped() {
        let run = &experiment.runs[0].manifest;
        if run.model.name() != "dem" {
            continue;
        }
        let bench = Bench::new();
        // Many discs take long.
        let is_large = ["dem_hopper_discharge", "dem_granular_gas", "dem_thousand_discs"]
            .iter()
            .any(|name| path.file_stem().is_some_and(|stem| stem == *name));
        let shorter = |line: &str| match line.strip_prefix("duration_s = ") {
            Some(duration) => {
                let duration = duration.parse::<f64>().unwrap();
                format!("duration_s = {}\n", duration / if is_large { 32.0 } else { 4.0 })
            }
            None => format!("{line}\n"),
        };
        bench.write("run.toml", &run.canonical().lines().map(shorter).collect::<String>());
        let ran = bench.call(&["run", "--quiet", "run.toml"]);
        assert_eq!(ran.code, Some(0), "{}: {}", path.display(), ran.err);
        let plot = |arguments: &[&str]| {
            let command = ["plot", "recordings/run", "--json", "--output", "p.svg"];
            let drawn = bench.call(&[&command, arguments].concat());
            assert_eq!(drawn.code, Some(0), "{}: {}", path.display(), drawn.err);
            drawn.json()["plot"].clone()
        };
        let stack = plot(&["--figure", "energy_balance"]);
        let residual = points(&plot(&["--y", "/energy.residual_j"])["curves"][0]);
        let work = points(&plot(&["--y", "/energy.wall_work_j"])["curves"][0]);
        let curves = stack["curves"].as_array().unwrap();
        let (sum, areas) = curves.split_last().unwrap();
        assert!(areas.iter().all(|area| area["style"] == "area"), "{areas:?}");
        let (tops, sums) = (points(areas.last().unwrap()), points(sum));
        assert_eq!((tops.len(), sums.len()), (residual.len(), residual.len()));
        let given = sums.iter().copied().fold(0.0, |most, sum| if sum > most { sum } else { most });
        for ((top, sum), residual) in tops.iter().zip(&sums).zip(&residual) {
            let missed = top - sum - residual;
            assert!(missed.abs() <= 1e-9 * given, "{}: {missed} of {given} J", path.display());
        }
        for pair in areas.windows(2) {
            let (lower, upper) = (points(&pair[0]), points(&pair[1]));
            assert!(lower.iter().zip(&upper).all(|(low, high)| low <= high), "{}", path.display());
        }
        let ends = (tops.last().unwrap(), sums.last().unwrap(), work.last().unwrap());
        if path.ends_with("dem_rotating_drum.toml") {
            assert!(ends.0 - (ends.1 - ends.2) > 0.1 * given, "control: {ends:?}");
        }
        kinds.extend(curves.iter().map(|curve| curve["name"].as_str().unwrap().to_owned()));
        runs += 1;
    }
    assert!(runs >= 16, "{runs}");
    for kind in ["lost in friction", "left with discs", "start + work of walls", "start + inserted"]
    {
        assert!(kinds.iter().any(|name| name == kind), "{kind}: {kinds:?}");
    }
}
