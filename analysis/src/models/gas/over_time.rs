//! Charts of a gas run over time: temperature, particles that have left, and wall collisions, each with its law.

use super::laws as law;
use super::observe::GasRun;
use crate::models::figures::time_axis;
use crate::number_text::short_number;
use crate::plot::{Axis, Curve, Plot};
use kinetoscope_manifest::model::TemperatureDefinition;

/// The metrics that the chart of the temperature shows.
pub(super) const TEMPERATURES: &[&str] = &[
    "temperature.mean_square",
    "temperature.mean_speed",
    "temperature.thermalized",
    "temperature.max_change_relative",
    "adiabatic_invariant",
    "pressure.mean_speed_formula",
];

/// All charts that the run has the values of.
pub(super) fn charts(run: &GasRun) -> Vec<Plot> {
    [temperature(run), escaped(run), wall_collisions(run)].into_iter().flatten().collect()
}

/// Temperature by the mean square and, where the manifest defines it so, by the mean speed.
fn temperature(run: &GasRun) -> Option<Plot> {
    let series = &run.temperatures;
    let &(begin, first, _) = series.first().filter(|_| series.len() > 1)?;
    let config = &run.config;
    let is_by_speed = config.temperature_definition == TemperatureDefinition::MeanSpeed;
    let by_square = if is_by_speed { "by ⟨v²⟩" } else { "measured" };
    let mut curves =
        vec![Curve::line(by_square, 0, series.iter().map(|&(t, square, _)| (t, square)))];
    if is_by_speed {
        curves.push(Curve::line("by ⟨v⟩²", 2, series.iter().map(|&(t, _, speed)| (t, speed))));
    }
    // A logarithmic axis cannot show time 0.
    let first_shown = series.iter().map(|(time, ..)| *time).find(|time| *time > 0.0);
    let starts = [Some(begin), first_shown];
    let ends = || starts.into_iter().flatten().chain(series.last().map(|(time, ..)| *time));
    let level = |value: f64| ends().map(move |time| (time, value));
    let opens = config.partition.and_then(|partition| partition.opens_s);
    if config.wall_speed_m_per_s.get() != 0.0 {
        // Adiabatic in two dimensions: T A is constant.
        let start = run.radii.first().map_or(1.0, |(_, radius)| *radius);
        let line =
            run.radii.iter().map(|(time, radius)| (*time, first * libm::pow(start / radius, 2.0)));
        curves.push(Curve::theory("T A = constant", 1, line));
    } else if let Some(wall) = config.thermal_wall {
        curves.push(Curve::theory("temperature of the wall", 1, level(wall.temperature_k.get())));
    } else if !config.temperature_schedule.is_empty() {
        let steps = steps(run, begin, ends().last().unwrap_or(begin));
        curves.push(Curve::theory("set by the manifest", 1, steps));
    } else if !is_by_speed && (run.keeps_energy() || opens.is_some()) {
        curves.push(Curve::theory("temperature at the start", 1, level(first)));
    }
    let across = time_axis(series.iter().map(|(time, ..)| *time), "s");
    let axes = [across, Axis::linear("temperature", "K")];
    Some(Plot::chart("temperature_over_time", "Temperature", axes, curves))
}

/// The temperatures of the schedule as steps, by the definition of the manifest.
fn steps(run: &GasRun, begin: f64, end: f64) -> Vec<(f64, f64)> {
    let is_by_speed = run.config.temperature_definition == TemperatureDefinition::MeanSpeed;
    let first = run.temperatures.first().map_or(
        0.0,
        |&(_, square, speed)| {
            if is_by_speed { speed } else { square }
        },
    );
    let mut steps = vec![(begin, first)];
    for [time, temperature] in &run.config.temperature_schedule {
        let last = steps.last().map_or(first, |(_, value)| *value);
        steps.extend([(time.get(), last), (time.get(), temperature.get())]);
    }
    let last = steps.last().map_or(first, |(_, value)| *value);
    steps.push((end, last));
    steps
}

/// Number of particles that have left, with that of a well mixed gas.
fn escaped(run: &GasRun) -> Option<Plot> {
    let speed = run.first_mean_speed_m_per_s?;
    let mixed = |time: f64| law::escaped(&run.config, speed, time);
    let law: Option<Vec<(f64, f64)>> =
        run.escaped.iter().map(|(time, _)| Some((*time, mixed(*time)?))).collect();
    let curves = vec![
        Curve::line("counted", 0, run.escaped.iter().copied()),
        Curve::theory("kinetic theory, N (1 − exp(−t/τ)), 1/τ = ⟨v⟩ w / (π A)", 1, law?),
    ];
    let axes = [Axis::linear("time", "s"), Axis::linear("particles that have left", "")];
    Some(Plot::chart("escaped_over_time", "Particles that have left", axes, curves))
}

/// Number of wall collisions with that of a uniform gas.
fn wall_collisions(run: &GasRun) -> Option<Plot> {
    let mean_speed = run.first_mean_speed_m_per_s.filter(|_| run.keeps_particles())?;
    let (end, _) = *run.wall_counts.last().filter(|_| run.wall_counts.len() > 1)?;
    let rate = law::wall_collision_rate_per_s(&run.config, mean_speed);
    let name = format!("kinetic theory, {} per second", short_number(rate));
    let curves = vec![
        Curve::line("counted", 0, run.wall_counts.iter().copied()),
        Curve::theory(name, 1, [(0.0, 0.0), (end, rate * end)]),
    ];
    let axes = [Axis::linear("time", "s"), Axis::linear("wall collisions", "")];
    Some(Plot::chart("wall_collisions_over_time", "Collisions with the wall", axes, curves))
}
