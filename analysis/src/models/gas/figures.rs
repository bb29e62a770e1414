//! Plots of a gas run: pressure over time, speed histogram with its distributions, snapshots.

use super::box_entropy::entropy_at_equilibrium;
use super::laws as law;
use super::layers::{BarometricLaw, LAYERS, counts, relative_density};
use super::observe::GasRun;
use super::over_time;
use crate::models::contract::{NamedChart, PlottedObserver};
use crate::models::figures::{Figures, pictures, time_axis};
use crate::number_text::short_number;
use crate::plot::{Axis, Curve, CurveStyle, Plot};
use kinetoscope_recording::channels::GasSpeeds;

/// The charts that a plot may name.
pub(super) const CHARTS: &[NamedChart] = &[
    NamedChart::new("temperature_over_time", over_time::TEMPERATURES),
    NamedChart::new("escaped_over_time", &["effusion_rate"]),
    NamedChart::new("wall_collisions_over_time", &["wall_collision_rate"]),
    NamedChart::new("pressure_over_time", PRESSURES),
    NamedChart::new("speed_histogram", SPEEDS),
    NamedChart::new("h_over_time", &["relative_entropy", "relative_entropy.start", "h_function"]),
    NamedChart::new("density_by_height", &["layers.chi_square_per_layer", "layers.mean_height"]),
    NamedChart::of_all_states(
        "box_entropy_over_time",
        &["box_entropy.start", "box_entropy.change"],
    ),
];

const PRESSURES: &[&str] =
    &["pressure.measured", "pressure.mean_speed_formula", "pressure.mean_square_formula"];
const SPEEDS: &[&str] = &[
    "speed_histogram.chi_square_per_bin",
    "speed_histogram.total_variation_distance",
    "a2",
    "mean_speed_over_rms",
    "relative_entropy",
];

impl PlottedObserver for GasRun {
    fn figures(&self) -> Figures {
        let mut plots: Vec<Plot> = over_time::charts(self);
        if self.pressure_series.len() > 1 {
            plots.push(pressure(self));
        }
        if let Some(histogram) = &self.histogram {
            plots.push(speeds(histogram, self.config.particles.get()));
        }
        if self.relative_entropy.len() > 1 && !self.config.keeps_speeds() {
            plots.push(h_over_time(self));
        }
        plots.extend(density_by_height(self));
        if self.box_entropy.len() > 1 {
            plots.push(entropy_over_time(self));
        }
        let radius = short_number(self.config.radius_m.get());
        let caption = |count: &str, time: &str| format!("{count}, r = {radius} m, t = {time} s");
        let size = format!("circle of radius {radius} m");
        plots.extend(pictures(&self.snapshots, "Gas", caption, &size));
        Figures { plots, ..Figures::default() }
    }
}

/// Density over height against the barometric law; `None` without gravity.
fn density_by_height(run: &GasRun) -> Option<Plot> {
    let law = BarometricLaw::of(&run.config)?;
    let (counts, _) = counts(run.snapshots.last()?, &run.config)?;
    let particles = f64::from(run.config.particles.get());
    let radius = run.config.radius_m.get();
    let height = |layer: usize| radius * ((2 * layer + 1) as f64 / LAYERS as f64 - 1.0);
    let over_height = |fraction: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        (0..LAYERS).map(|l| (height(l), relative_density(l, fraction(l)))).collect()
    };
    let points = over_height(&|layer| counts[layer] / particles);
    let mut measured = Curve::new("measured", CurveStyle::Data, 0, points);
    for (layer, point) in measured.points.iter_mut().enumerate() {
        point.error = Some(relative_density(layer, counts[layer].sqrt() / particles));
    }
    let theory = over_height(&|layer| law.fractions[layer]);
    let curves = vec![measured, Curve::theory("barometric law", 1, theory)];
    let axes =
        [Axis::linear("height above the center", "m"), Axis::linear("density over the mean", "1")];
    Some(Plot::chart("density_by_height", "Density by height", axes, curves))
}

/// Entropy by boxes over time, with that of a uniform gas if the partition is removed.
fn entropy_over_time(run: &GasRun) -> Plot {
    let series = &run.box_entropy;
    let mut curves = vec![Curve::line("measured", 0, series.iter().copied())];
    let is_removed = run.config.partition.is_some_and(|partition| partition.opens_s.is_some());
    if let Some(entropy) = entropy_at_equilibrium(&run.config).filter(|_| is_removed) {
        // A logarithmic axis cannot show time 0.
        let first_shown = series.iter().find(|(time, _)| *time > 0.0);
        let times = series.first().into_iter().chain(first_shown).chain(series.last());
        let level = times.map(|(time, _)| (*time, entropy));
        curves.push(Curve::theory("uniform gas in the whole container", 1, level));
    }
    let across = time_axis(series.iter().map(|(time, _)| *time), "s");
    let axes = [across, Axis::linear("entropy per particle, by boxes", "k_B")];
    Plot::chart("box_entropy_over_time", "Entropy", axes, curves)
}

/// Relative entropy over time: Boltzmann's H above its minimum.
fn h_over_time(run: &GasRun) -> Plot {
    let series = &run.relative_entropy;
    let mut curves = vec![Curve::line("measured", 0, series.iter().copied())];
    let collides = run.config.keeps_energy() && run.config.disc_radius_m.is_some();
    if let Some([scatter, _]) = run.relaxed_entropy().filter(|_| collides) {
        let level = series.ends().map(|(time, _)| (*time, scatter));
        curves.push(Curve::theory("Maxwell's speeds, N discs in as many bins", 2, level));
    }
    let axes = [Axis::linear("time", "s"), Axis::logarithmic("H above its least value", "1")];
    Plot::chart("h_over_time", "Boltzmann's H", axes, curves)
}

fn pressure(run: &GasRun) -> Plot {
    let series = &run.pressure_series;
    let level = |value: f64| series.ends().map(move |(time, _)| (*time, value));
    let mut curves = vec![Curve::line("measured since the start", 0, series.iter().copied())];
    // In gravity, next to a moving or thermal wall, and where particles leave, no level follows from the speeds alone; that of discs
    // follows from their collisions as well.
    let is_of_points = run.config.disc_radius_m.is_none() && run.keeps_energy_of_one_mass();
    if let Some(square) = run.mean_square().filter(|_| run.keeps_energy_of_one_mass()) {
        if is_of_points {
            let exact = law::pressure_n_per_m(&run.config, square);
            curves.push(Curve::theory("kinetic theory, N m ⟨v²⟩ / (2A)", 1, level(exact)));
        } else if let Some(exact) = run.pressure_by_virial(square) {
            curves.push(Curve::theory("by ⟨v²⟩ and the virial of the collisions", 1, level(exact)));
        }
    }
    if let Some(pressure) = run.pressure.as_ref().filter(|_| is_of_points) {
        let formula = pressure.mean_speed_formula_n_per_m;
        curves.push(Curve::theory("by the mean speed, N m ⟨v⟩² / (2A)", 2, level(formula)));
    }
    let axes = [Axis::linear("time", "s"), Axis::linear("pressure", "N/m")];
    Plot::chart("pressure_over_time", "Pressure on the wall", axes, curves)
}

fn speeds(histogram: &GasSpeeds, particles: u32) -> Plot {
    let speeds = &histogram.speed_m_per_s;
    let over_speed = |values: &[f64]| -> Vec<(f64, f64)> {
        speeds.iter().copied().zip(values.iter().copied()).collect()
    };
    let mut measured = Curve::new("measured", CurveStyle::Data, 0, over_speed(&histogram.density));
    let width = if speeds.len() > 1 { speeds[1] - speeds[0] } else { 0.0 };
    for point in &mut measured.points {
        // A bin with k particles has the standard error sqrt(k).
        point.error = Some((point.y / (f64::from(particles) * width)).sqrt());
    }
    let mut curves = vec![measured];
    // Zeros stand for a single initial speed, which has no density to draw.
    if histogram.initial_distribution.iter().any(|density| *density > 0.0) {
        let initial = over_speed(&histogram.initial_distribution);
        curves.push(Curve::theory("initial distribution", 1, initial));
    }
    curves.push(Curve::theory("Maxwell, same ⟨v²⟩", 2, over_speed(&histogram.maxwell)));
    let axes = [Axis::linear("speed", "m/s"), Axis::linear("density", "s/m")];
    Plot::chart("speed_histogram", "Speeds at the end", axes, curves)
}
