//! Plots of a packing run: temperature and a2 against collisions, discs at the end.

use super::{Comparison, Figures, chart, count_text, curve};
use crate::laws::packing as law;
use crate::observables::packing::{Moments, PackingRun};
use crate::plot::{Axis, Container, Picture, Plot, Point, Style, short_number, thinned};

/// All plots of a run.
#[must_use]
pub fn figures(run: &PackingRun) -> Figures {
    let mut figures = Figures::default();
    if !series(run).is_empty() {
        figures.plots.push(temperature(run));
        figures.plots.push(a2(run));
        figures.comparisons.push(comparison(run));
    }
    if !run.snapshot.bodies.is_empty() {
        figures.plots.push(Plot::Picture(state(run)));
    }
    figures
}

/// Collision by collision where that was recorded, else frame by frame.
fn series(run: &PackingRun) -> &[Moments] {
    let collisions = run.collisions.entries();
    if collisions.is_empty() { &run.frames } else { collisions }
}

fn collisions_axis() -> Axis {
    Axis::linear("collisions, pair and wall", "")
}

fn temperature(run: &PackingRun) -> Plot {
    let measured = series(run).iter().map(|moments| (moments.events, moments.temperature));
    let mut curves = vec![curve("T = <v²>", Style::Line, 0, measured)];
    if let Some(start) = run.frames.first() {
        let restitution = run.config.restitution.get();
        let discs = run.config.discs.get();
        let theory = run.pairs.iter().map(|(events, pairs)| {
            (*events, start.temperature * law::cooling(restitution, *pairs, discs))
        });
        let name =
            if restitution == 1.0 { "T at the start" } else { "Haff, T₀ exp(−(1−α²) C/n)" };
        curves.push(curve(name, Style::Theory, 1, theory));
    }
    let ends = [run.frames.first(), run.frames.last()].map(|end| end.map(|end| end.temperature));
    let cooled = matches!(ends, [Some(first), Some(last)] if last < first / 30.0);
    let y = if cooled { Axis::logarithmic("T = <v²>", "") } else { Axis::linear("T = <v²>", "") };
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
    let curves = vec![curve("a₂", Style::Line, 0, measured), curve(name, Style::Theory, 1, level)];
    let y = Axis::linear("a₂ = <v⁴> / (2 <v²>²) − 1", "");
    chart("a2", "Departure from Maxwell against collisions", collisions_axis(), y, curves)
}

fn comparison(run: &PackingRun) -> Comparison {
    let discs = f64::from(run.config.discs.get());
    let start = run.frames.first().map_or(1.0, |moments| moments.temperature);
    let points = series(run)
        .iter()
        .map(|moments| Point::bare(moments.events / discs, moments.temperature / start));
    Comparison {
        stem: "temperature_by_run",
        title: "Temperature over its start",
        x: Axis::linear("collisions a disc, pair and wall", ""),
        y: Axis::linear("T / T at the start", ""),
        points: thinned(points.collect(), super::MOST_POINTS),
    }
}

fn state(run: &PackingRun) -> Picture {
    let (half_width, half_height) = (run.config.width.get() / 2.0, run.config.height.get() / 2.0);
    let count = count_text(run.snapshot.particles, run.snapshot.bodies.len());
    Picture {
        stem: "state_at_end".to_owned(),
        title: "Discs at the end".to_owned(),
        caption: format!(
            "{count}, r = {}, packing fraction {}, t = {}",
            short_number(run.config.radius.get()),
            short_number(law::packing_fraction(&run.config)),
            short_number(run.snapshot.time)
        ),
        length_unit: String::new(),
        speed_unit: String::new(),
        container: Container::Rectangle([-half_width, -half_height], [half_width, half_height]),
        bodies: run.snapshot.bodies.clone(),
    }
}
