//! Plots of a packing run: temperature and a2 over collisions, structure, displacement, snapshots.

use super::laws as law;
use super::observe::{PackingRun, VelocityMoments};
use crate::models::contract::PlottedObserver;
use crate::models::figures::{Figures, SharedCurve, box_text, chart, curve, pictures};
use crate::models::series::Series;
use crate::plot::{Axis, CurveStyle, Plot, Point, short_number, thinned};

impl PlottedObserver for PackingRun {
    fn figures(&self) -> Figures {
        let run = self;
        let mut figures = Figures::default();
        if !series(run).is_empty() {
            figures.plots.push(temperature(run));
            figures.plots.push(a2(run));
            figures.comparisons.push(comparison(run));
        }
        figures.plots.extend(structure(run));
        figures.plots.extend(displacement(run));
        figures.plots.extend(states(run));
        figures
    }
}

/// The moments per collision if recorded, else per frame.
fn series(run: &PackingRun) -> &Series<VelocityMoments> {
    if run.collisions.is_empty() { &run.frames } else { &run.collisions }
}

fn collisions_axis() -> Axis {
    Axis::linear("collisions, pair and wall", "")
}

fn temperature(run: &PackingRun) -> Plot {
    let measured = series(run).iter().map(|moments| (moments.events, moments.temperature));
    let mut curves = vec![curve("T = <v²>/2", CurveStyle::Line, 0, measured)];
    if let Some(start) = run.frames.first() {
        let restitution = run.config.restitution.get();
        let discs = run.config.discs.get();
        let theory = run.pairs.iter().map(|(events, pairs)| {
            (*events, start.temperature * law::cooling(restitution, *pairs, discs))
        });
        let name =
            if restitution == 1.0 { "T at the start" } else { "Haff, T₀ exp(−(1−α²) C/n)" };
        curves.push(curve(name, CurveStyle::Theory, 1, theory));
    }
    let ends = [run.frames.first(), run.frames.last()].map(|end| end.map(|end| end.temperature));
    let cooled = matches!(ends, [Some(first), Some(last)] if last < first / 30.0);
    let y =
        if cooled { Axis::logarithmic("T = <v²>/2", "") } else { Axis::linear("T = <v²>/2", "") };
    chart("temperature", "Temperature against collisions", collisions_axis(), y, curves)
}

fn a2(run: &PackingRun) -> Plot {
    let measured: Vec<(f64, f64)> =
        series(run).iter().map(|moments| (moments.events, moments.a2)).collect();
    let restitution = run.config.restitution.get();
    let (theory, name) = if restitution == 1.0 {
        (law::a2_at_fixed_energy(run.config.discs.get()), "mean at fixed energy, −1/(n + 1)")
    } else {
        (law::a2_cooling(restitution), "homogeneous cooling state")
    };
    let ends = [measured.first().copied(), measured.last().copied()];
    let level: Vec<(f64, f64)> =
        ends.into_iter().flatten().map(|(events, _)| (events, theory)).collect();
    let curves =
        vec![curve("a₂", CurveStyle::Line, 0, measured), curve(name, CurveStyle::Theory, 1, level)];
    let y = Axis::linear("a₂ = <v⁴> / (2 <v²>²) − 1", "");
    chart("a2", "Departure from Maxwell against collisions", collisions_axis(), y, curves)
}

fn comparison(run: &PackingRun) -> SharedCurve {
    let discs = f64::from(run.config.discs.get());
    let start = run.frames.first().map_or(1.0, |moments| moments.temperature);
    let points = series(run)
        .iter()
        .map(|moments| Point::bare(moments.events / discs, moments.temperature / start));
    SharedCurve {
        stem: "temperature_by_run".to_owned(),
        title: "Temperature over its start".to_owned(),
        x: Axis::linear("collisions per disc, pair and wall", ""),
        y: Axis::linear("T / T at the start", ""),
        points: thinned(points.collect(), crate::models::figures::MAX_POINTS),
    }
}

fn structure(run: &PackingRun) -> Option<Plot> {
    let correlation = run.sampled_structure().pair_correlation();
    let end = correlation.last()?.0;
    let curves = vec![
        curve("measured", CurveStyle::Line, 0, correlation),
        curve("points at random", CurveStyle::Theory, 1, [(0.0, 1.0), (end, 1.0)]),
    ];
    let (x, y) = (Axis::linear("distance / diameter", ""), Axis::linear("g(r)", ""));
    Some(chart("pair_correlation", "Pair correlation of the discs", x, y, curves))
}

/// Ratio of the last to the first frame interval above which a linear time axis would hide the first frames.
const STRETCHED: f64 = 10.0;

/// Whether the frame interval grows, as for frames that are even in the logarithm of time.
fn times_stretch(series: &Series<(f64, f64)>) -> bool {
    let times: Vec<f64> = series.iter().map(|&(time, _)| time).collect();
    let gaps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.first().zip(gaps.last()).is_some_and(|(first, last)| *last > STRETCHED * first)
}

fn displacement(run: &PackingRun) -> Vec<Plot> {
    let (moved, memory) =
        (&run.displacement.mean_square, &run.displacement.velocity_autocorrelation);
    let mut plots = Vec::new();
    if moved.len() > 1 {
        let curves = vec![curve("<|x − x(0)|²>", CurveStyle::Line, 0, moved.iter().copied())];
        let axis = if times_stretch(moved) { Axis::logarithmic } else { Axis::linear };
        let (x, y) = (axis("time", ""), axis("mean square displacement", ""));
        let title = "How far the discs have gone";
        plots.push(chart("mean_square_displacement", title, x, y, curves));
    }
    if memory.len() > 1 {
        // A logarithmic axis cannot show time 0.
        let ends = [memory.iter().find(|(time, _)| *time > 0.0), memory.last()];
        let level = ends.into_iter().flatten().map(|(time, _)| (*time, 0.0));
        let curves = vec![
            curve("Σ v · v(0) / Σ v(0)²", CurveStyle::Line, 0, memory.iter().copied()),
            curve("forgotten", CurveStyle::Theory, 1, level),
        ];
        let axis = if times_stretch(memory) { Axis::logarithmic } else { Axis::linear };
        let (x, y) = (axis("time", ""), Axis::linear("velocity autocorrelation", ""));
        let title = "How the discs forget their velocities";
        plots.push(chart("velocity_autocorrelation", title, x, y, curves));
    }
    plots
}

fn states(run: &PackingRun) -> Vec<Plot> {
    let fraction = run.packing_fraction().map_or("unknown".to_owned(), short_number);
    let radius = match run.equal_radius() {
        Some(radius) => format!("r = {}", short_number(radius)),
        None => "several radii".to_owned(),
    };
    let caption = |count: &str, time: &str| {
        format!("{count}, {radius}, packing fraction {fraction}, t = {time}")
    };
    let size = box_text([run.config.width.get(), run.config.height.get()], "");
    pictures(&run.snapshots, "Discs", caption, &size)
}
