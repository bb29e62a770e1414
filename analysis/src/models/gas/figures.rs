//! Plots of a gas run: pressure over time, speed histogram with its distributions, snapshots.

use super::laws as law;
use super::observe::GasRun;
use crate::models::contract::PlottedObserver;
use crate::models::figures::{Figures, chart, curve, pictures};
use crate::plot::{Axis, CurveStyle, Plot, short_number};
use kinetoscope_recording::channels::GasSpeeds;

impl PlottedObserver for GasRun {
    fn figures(&self) -> Figures {
        let run = self;
        let mut figures = Figures::default();
        if run.pressure_series.len() > 1 {
            figures.plots.push(pressure(run));
        }
        if let Some(histogram) = &run.histogram {
            figures.plots.push(speeds(histogram, run.config.particles.get()));
        }
        if run.kinetics.relative_entropy.len() > 1 && !run.config.keeps_speeds() {
            figures.plots.push(h_over_time(run));
        }
        figures.plots.extend(states(run));
        figures
    }
}

/// Relative entropy over time: Boltzmann's H above its minimum.
fn h_over_time(run: &GasRun) -> Plot {
    let series = &run.kinetics.relative_entropy;
    let mut curves = vec![curve("measured", CurveStyle::Line, 0, series.iter().copied())];
    if run.config.keeps_energy() && run.config.disc_radius_m.is_some() {
        let scatter = run.kinetics.bins.saturating_sub(2) as f64
            / (2.0 * f64::from(run.config.particles.get()));
        let ends = [series.first(), series.last()].into_iter().flatten();
        let level = ends.map(|(time, _)| (*time, scatter));
        curves.push(curve(
            "Maxwell's speeds, N discs in as many bins",
            CurveStyle::Theory,
            2,
            level,
        ));
    }
    let (x, y) = (Axis::linear("time", "s"), Axis::logarithmic("H above its least value", "1"));
    chart("h_over_time", "Boltzmann's H", x, y, curves)
}

fn pressure(run: &GasRun) -> Plot {
    let ends = [run.pressure_series.first(), run.pressure_series.last()];
    let level = |value: f64| ends.into_iter().flatten().map(move |(time, _)| (*time, value));
    let mut curves = vec![curve(
        "measured since the start",
        CurveStyle::Line,
        0,
        run.pressure_series.iter().copied(),
    )];
    if let Some(square) = run.mean_square() {
        let exact = law::pressure_n_per_m(&run.config, square);
        curves.push(curve("N m <v²> / (2A)", CurveStyle::Theory, 1, level(exact)));
    }
    if let Some(pressure) = &run.pressure {
        let formula = pressure.mean_speed_formula_n_per_m;
        curves.push(curve("N m <v>² / (2A), formula (12)", CurveStyle::Theory, 2, level(formula)));
    }
    let (x, y) = (Axis::linear("time", "s"), Axis::linear("pressure", "N/m"));
    chart("pressure_over_time", "Pressure on the wall", x, y, curves)
}

fn speeds(histogram: &GasSpeeds, particles: u32) -> Plot {
    let against = |values: &[f64]| -> Vec<(f64, f64)> {
        histogram.speed_m_per_s.iter().copied().zip(values.iter().copied()).collect()
    };
    let mut measured = curve("measured", CurveStyle::Data, 0, against(&histogram.density));
    let bins = &histogram.speed_m_per_s;
    let width = if bins.len() > 1 { bins[1] - bins[0] } else { 0.0 };
    for point in &mut measured.points {
        // A bin with k particles has the standard error sqrt(k).
        point.error = Some((point.y / (f64::from(particles) * width)).sqrt());
    }
    let mut curves = vec![measured];
    // Zeros stand for a single initial speed, which has no density to draw.
    if histogram.initial_distribution.iter().any(|density| *density > 0.0) {
        let law = against(&histogram.initial_distribution);
        curves.push(curve("initial distribution", CurveStyle::Theory, 1, law));
    }
    curves.push(curve("Maxwell, same <v²>", CurveStyle::Theory, 2, against(&histogram.maxwell)));
    let (x, y) = (Axis::linear("speed", "m/s"), Axis::linear("density", "s/m"));
    chart("speed_histogram", "Speeds at the end", x, y, curves)
}

fn states(run: &GasRun) -> Vec<Plot> {
    let radius = short_number(run.config.radius_m.get());
    let caption = |count: &str, time: &str| format!("{count}, r = {radius} m, t = {time} s");
    pictures(&run.snapshots, "Gas", caption, &format!("circle of radius {radius} m"))
}
