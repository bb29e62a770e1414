//! Plots of a packing run: temperature and a2 over collisions, structure, displacement, snapshots.

use super::gravity::density_by_height;
use super::laws as law;
use super::mean_a2::VelocityMoments;
use super::observe::PackingRun;
use crate::models::contract::{NamedChart, PlottedObserver};
use crate::models::figures::{Figures, SharedCurve, box_text, pictures, time_axis};
use crate::models::series::Series;
use crate::number_text::short_number;
use crate::plot::{Axis, Curve, CurveStyle, Plot};

/// The charts that a plot may name.
pub(super) const CHARTS: &[NamedChart] = &[
    NamedChart::new("temperature", &["temperature.final", "temperature.final_over_initial"]),
    NamedChart::new("temperature_by_run", &["temperature.final_over_initial"]),
    NamedChart::new("collision_rate", &["pair_collision_rate_per_disc", "mean_free_time"]),
    NamedChart::of_all_states("pressure_over_time", &["compressibility_factor"]),
    NamedChart::of_all_states("density_by_height", &["height.mean"]),
    NamedChart::new("a2", &["a2.mean", "a2.final"]),
    NamedChart::of_all_states("pair_correlation", &["pair_correlation.near_contact"]),
    NamedChart::of_all_states("speed_distribution", &["a2.mean"]),
    NamedChart::of_all_states("free_times", &["mean_free_time"]),
    NamedChart::of_all_states("free_paths", &["mean_free_path"]),
    NamedChart::of_all_states("local_packing_fraction", &["packing_fraction"]),
    NamedChart::of_all_states("hexatic_correlation", &["psi6.correlation_exponent"]),
    NamedChart::of_all_states("structure_factor", &["structure_factor.longest_waves"]),
    NamedChart::of_all_states("mean_square_displacement", &["mean_square_displacement.final"]),
    NamedChart::of_all_states("velocity_autocorrelation", &["velocity_autocorrelation.final"]),
];

impl PlottedObserver for PackingRun {
    fn figures(&self) -> Figures {
        let mut figures = Figures::default();
        if !series(self).is_empty() {
            figures.plots.extend([temperature(self), a2(self)]);
            figures.plots.extend(collision_rate(self).into_iter().chain(pressure(self)));
            figures.comparisons.push(comparison(self));
        }
        figures.plots.extend(density_by_height(self));
        figures.plots.extend(pair_correlation(self));
        figures.plots.extend(speed_distribution(self));
        figures.plots.extend(free_flights(self));
        figures.plots.extend(local_packing_fraction(self));
        figures.plots.extend(hexatic_correlation(self));
        figures.plots.extend(structure_factor(self));
        figures.plots.extend(displacement(self));
        let fraction = self.packing_fraction().map_or("unknown".to_owned(), short_number);
        let radius = match self.equal_radius() {
            Some(radius) => format!("r = {}", short_number(radius)),
            None => "several radii".to_owned(),
        };
        let caption = |count: &str, time: &str| {
            format!("{count}, {radius}, packing fraction {fraction}, t = {time}")
        };
        let size = box_text([self.config.width.get(), self.config.height.get()], "");
        figures.plots.extend(pictures(&self.snapshots, "Discs", caption, &size));
        figures
    }
}

/// The moments per collision if recorded in all frames, else per frame.
fn series(run: &PackingRun) -> &Series<VelocityMoments> {
    if run.collisions.is_empty() || run.lacks_states { &run.frames } else { &run.collisions }
}

fn over_events(run: &PackingRun, y: Axis) -> [Axis; 2] {
    let events = match run.has_walls() {
        true => "events (collisions of two discs, and with walls)",
        false => "events (collisions of two discs)",
    };
    [Axis::linear(events, ""), y]
}

fn temperature(run: &PackingRun) -> Plot {
    let measured = series(run).iter().map(|moments| (moments.events, moments.temperature));
    let mut curves = vec![Curve::line("T = ⟨v²⟩/2", 0, measured)];
    let follows = !run.falls() && (run.is_elastic() || !run.has_obstacles());
    if let Some(start) = run.frames.first().filter(|_| follows) {
        let restitution = run.config.restitution.get();
        let discs = run.config.discs.get();
        let theory = run.pairs.iter().map(|(events, pairs)| {
            (*events, start.temperature * law::cooling(restitution, *pairs, discs))
        });
        let name = if restitution == 1.0 {
            "T at the start"
        } else {
            "Haff's law, T₀ exp(−(1−e²) C/N)"
        };
        curves.push(Curve::theory(name, 1, theory));
    }
    let ends = [run.frames.first(), run.frames.last()];
    let cooled =
        matches!(ends, [Some(first), Some(last)] if last.temperature < first.temperature / 30.0);
    let axis = if cooled { Axis::logarithmic } else { Axis::linear };
    let axes = over_events(run, axis("T = ⟨v²⟩/2", ""));
    Plot::chart("temperature", "Temperature by number of events", axes, curves)
}

/// Pressure over that of an ideal gas since the start, with the equation of state where it applies.
fn pressure(run: &PackingRun) -> Option<Plot> {
    let ends = [run.pressures.first()?.0, run.pressures.last()?.0];
    let mut curves =
        vec![Curve::line("measured since the start", 0, run.pressures.iter().copied())];
    let theory = run.equilibrium().map(|equilibrium| equilibrium.compressibility());
    if let Some(theory) = theory.filter(|theory| theory.violation.is_none()) {
        curves.push(Curve::theory("equation of state", 1, ends.map(|end| (end, theory.value))));
    }
    let axes = [Axis::linear("time", ""), Axis::linear("pressure / that of an ideal gas", "")];
    Some(Plot::chart("pressure_over_time", "Pressure over that of an ideal gas", axes, curves))
}

/// Collisions per disc with others and unit of time since the start, of elastic discs with theory.
fn collision_rate(run: &PackingRun) -> Option<Plot> {
    let per_disc = 2.0 / f64::from(run.config.discs.get());
    // Both series have an entry per frame, unless a channel is not recorded in all of them.
    let frames = run.frames.iter().zip(run.pairs.iter());
    let same = frames.filter(|(moments, (events, _))| moments.events == *events);
    let rates = same.filter(|(moments, _)| moments.time > 0.0);
    let rates: Vec<(f64, f64)> = rates
        .map(|(moments, (_, pairs))| (moments.time, per_disc * pairs / moments.time))
        .collect();
    let (first, last) = (rates.first()?.0, rates.last()?.0);
    let mut curves = vec![Curve::line("measured since the start", 0, rates)];
    let theory = run.theory_rate().filter(|_| run.is_elastic());
    let in_range =
        |rate: &f64| run.equilibrium().is_some_and(|it| it.proportional(*rate).violation.is_none());
    if let Some(rate) = theory.filter(in_range) {
        curves.push(Curve::theory("Enskog's theory", 1, [(first, rate), (last, rate)]));
    }
    let axes = [Axis::linear("time", ""), Axis::linear("collision rate per disc", "")];
    Some(Plot::chart("collision_rate", "How often a disc collides with others", axes, curves))
}

fn a2(run: &PackingRun) -> Plot {
    let restitution = run.config.restitution.get();
    let (theory, name) = match (restitution == 1.0, run.keeps_momentum()) {
        (true, false) => {
            (law::a2_at_fixed_energy(run.config.discs.get()), "mean at fixed energy, −1/(N + 1)")
        }
        (true, true) => (-1.0 / run.discs(), "mean at fixed energy and momentum, −1/N"),
        (false, _) => (law::a2_cooling(restitution), "homogeneous cooling state"),
    };
    let curves = vec![
        Curve::line("a₂", 0, series(run).iter().map(|moments| (moments.events, moments.a2))),
        Curve::theory(name, 1, series(run).ends().map(|moments| (moments.events, theory))),
    ];
    let axes = over_events(run, Axis::linear("a₂ = ⟨v⁴⟩ / (2 ⟨v²⟩²) − 1", ""));
    Plot::chart("a2", "Departure from Maxwell by number of events", axes, curves)
}

fn comparison(run: &PackingRun) -> SharedCurve {
    let discs = f64::from(run.config.discs.get());
    let start = run.frames.first().map_or(1.0, |moments| moments.temperature);
    let points =
        series(run).iter().map(|moments| (moments.events / discs, moments.temperature / start));
    let axes = [Axis::linear("events per disc", ""), Axis::linear("T over T at the start", "")];
    SharedCurve::new("temperature_by_run", "Temperature relative to the start", axes, points)
}

fn pair_correlation(run: &PackingRun) -> Option<Plot> {
    if run.has_obstacles() {
        return None;
    }
    let correlation = run.sampled_structure().pair_correlation();
    let end = correlation.last()?.0;
    let curves = vec![
        Curve::line("measured", 0, correlation),
        Curve::theory("points at random", 1, [(0.0, 1.0), (end, 1.0)]),
    ];
    let axes = [Axis::linear("distance / diameter", ""), Axis::linear("g(r)", "")];
    Some(Plot::chart("pair_correlation", "Pair correlation of the discs", axes, curves))
}

/// Speeds in all settled frames, with Maxwell's distribution in two dimensions.
fn speed_distribution(run: &PackingRun) -> Option<Plot> {
    let found = run.distributions.speeds();
    found.first()?;
    let maxwell = found.iter().map(|(speed, ..)| (*speed, speed * libm::exp(-speed * speed / 2.0)));
    let maxwell: Vec<(f64, f64)> = maxwell.collect();
    let measured = measured_density(found.iter().copied());
    let curves = vec![measured, Curve::theory("Maxwell, same ⟨v²⟩", 1, maxwell)];
    let axes = [Axis::linear("speed / √T", ""), Axis::linear("density", "")];
    Some(Plot::chart("speed_distribution", "Speeds of the discs", axes, curves))
}

/// Places, and densities with their errors.
fn measured_density(rows: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Curve {
    let points = rows.clone().map(|(place, density, _)| (place, density));
    let mut measured = Curve::new("measured", CurveStyle::Data, 0, points);
    for (point, (.., error)) in measured.points.iter_mut().zip(rows) {
        point.error = Some(error);
    }
    measured
}

/// Times and paths between two collisions of a disc with others, with those of independent discs.
fn free_flights(run: &PackingRun) -> Vec<Plot> {
    let Some((distributions, applies)) = run.free_flight_distributions() else { return Vec::new() };
    let charts = [
        ("free_times", "Free times of the discs", "time / mean free time by theory"),
        ("free_paths", "Free paths of the discs", "path / mean free path by theory"),
    ];
    let plots = charts.into_iter().zip(distributions).map(|((stem, title, across), rows)| {
        let shown = rows.iter().map(|[middle, density, error, _]| (*middle, *density, *error));
        let mut curves = vec![measured_density(shown)];
        if applies {
            let theory = rows.iter().map(|[middle, .., theory]| (*middle, *theory));
            curves.push(Curve::theory("independent discs, rates by speed", 1, theory));
        }
        let exponential = rows.iter().map(|[middle, ..]| (*middle, libm::exp(-middle)));
        curves.push(Curve::theory("one rate for all speeds", 2, exponential));
        let axes = [Axis::linear(across, ""), Axis::logarithmic("density", "")];
        Plot::chart(stem, title, axes, curves)
    });
    plots.collect()
}

fn local_packing_fraction(run: &PackingRun) -> Option<Plot> {
    let found = run.distributions.local_packing_fractions();
    found.first()?;
    let of = |index: usize| found.iter().map(move |row| (row[0], row[index]));
    let curves = vec![
        Curve::line("measured, cells of five diameters", 0, of(1)),
        Curve::theory("points at random", 1, of(2)),
    ];
    let axes =
        [Axis::linear("local packing fraction", ""), Axis::linear("fraction of the cells", "")];
    Some(Plot::chart("local_packing_fraction", "Local packing fractions", axes, curves))
}

/// g6(r) with the steepest decay of a hexatic, from a quarter of the largest distance on.
fn hexatic_correlation(run: &PackingRun) -> Option<Plot> {
    let correlation = run.sampled_structure().long_range.hexatic_correlation();
    let (end, _) = *correlation.last()?;
    let (start, level) = *correlation.iter().find(|(distance, _)| *distance >= end / 4.0)?;
    let steepest =
        [start, end].map(|distance| (distance, level * libm::pow(distance / start, -0.25)));
    let curves = vec![
        Curve::line("measured", 0, correlation),
        Curve::theory("r^(−1/4), steepest of a hexatic", 1, steepest),
    ];
    let axes = [Axis::logarithmic("distance / diameter", ""), Axis::logarithmic("g₆(r)", "")];
    Some(Plot::chart("hexatic_correlation", "Decay of the hexagonal order", axes, curves))
}

fn structure_factor(run: &PackingRun) -> Option<Plot> {
    let factors = run.sampled_structure().long_range.structure_factor();
    let (first, last) = (factors.first()?.0, factors.last()?.0);
    let mut curves = vec![Curve::line("along sides and diagonals of the box", 0, factors)];
    if let Some(level) = run.expected_longest_waves() {
        curves.push(Curve::theory(
            "S(0), from the compressibility",
            1,
            [(first, level), (last, level)],
        ));
    }
    let axes = [Axis::linear("wave number × diameter", ""), Axis::linear("S(Q)", "")];
    Some(Plot::chart("structure_factor", "Structure factor of the discs", axes, curves))
}

fn displacement(run: &PackingRun) -> Vec<Plot> {
    let squares = &run.displacement.mean_square;
    let correlation = &run.displacement.velocity_autocorrelation;
    let mut plots = Vec::new();
    if squares.len() > 1 {
        let curves = vec![Curve::line("<|r − r(0)|²>", 0, squares.iter().copied())];
        let across = time_axis(squares.iter().map(|(time, _)| *time), "");
        let up = Axis { scale: across.scale, ..Axis::linear("mean square displacement", "") };
        let axes = [across, up];
        let title = "Mean square displacement";
        plots.push(Plot::chart("mean_square_displacement", title, axes, curves));
    }
    if correlation.len() > 1 {
        // A logarithmic axis cannot show time 0.
        let ends = [correlation.iter().find(|(time, _)| *time > 0.0), correlation.last()];
        let level = ends.into_iter().flatten().map(|(time, _)| (*time, 0.0));
        let curves = vec![
            Curve::line("Σ v · v(0) / Σ v(0)²", 0, correlation.iter().copied()),
            Curve::theory("uncorrelated", 1, level),
        ];
        let across = time_axis(correlation.iter().map(|(time, _)| *time), "");
        let axes = [across, Axis::linear("velocity autocorrelation", "")];
        let title = "Velocity autocorrelation function";
        plots.push(Plot::chart("velocity_autocorrelation", title, axes, curves));
    }
    plots
}
