//! Plots of a DEM run: energy balance, packing fraction and stress by height, snapshots.

use super::bed_shape;
use super::contact_constants;
use super::laws as law;
use super::observe::{DemRun, balance_j, supplied_j, total_j};
use super::special_setups;
use super::stress::StressLayer;
use crate::models::contract::{NamedChart, PlottedObserver};
use crate::models::figures::{Figures, SharedCurve, box_text, pictures};
use crate::models::series::Series;
use crate::number_text::short_number;
use crate::plot::{Axis, Curve, CurveStyle, Plot, Point, stacked};
use crate::statistics::Estimate;
use kinetoscope_manifest::model::DiscRadius;
use kinetoscope_recording::channels::DemEnergy;
use std::f64::consts::PI;

/// The charts that a plot may name.
pub(super) const CHARTS: &[NamedChart] = &[
    NamedChart::new("energy_balance", ENERGIES),
    NamedChart::new("energy_drift", ENERGY_ERRORS),
    NamedChart::new("energy_total_by_run", &["energy.total_change_relative"]),
    NamedChart::new("energy_residual_by_run", ENERGY_ERRORS),
    NamedChart::of_all_states("restitution_by_rebound", &["restitution.measured"]),
    NamedChart::new("cooling", &["cooling.rate", "granular_temperature"]),
    NamedChart::new("discharge", &["outlet.discharge_rate", "discs_removed"]),
    NamedChart::of_all_states("row_velocities", &["row.velocity_transmission"]),
    NamedChart::new("overlap_over_time", &["max_overlap_over_radius"]),
    NamedChart::new("surface", &["bed.surface_angle", "bed.normalized_runout"]),
    NamedChart::new("packing_by_height", &["bed.packing_fraction", "bed.height"]),
    NamedChart::of_all_states("stress_by_height", STRESSES),
];

const ENERGIES: &[&str] = &[
    "energy.kinetic",
    "energy.gravitational",
    "energy.elastic",
    "energy.dissipated",
    "energy.friction",
    "energy.friction_fraction",
    "energy.wall_work",
    "energy.total_change_relative",
    "energy.residual_relative",
    "energy.max_residual_relative",
    "settling_time",
];
const ENERGY_ERRORS: &[&str] = &["energy.residual_relative", "energy.max_residual_relative"];
const STRESSES: &[&str] = &[
    "stress.vertical_at_floor",
    "stress.vertical_at_mid_height",
    "stress.lateral_ratio",
    "stress.overburden_deviation",
];

impl PlottedObserver for DemRun {
    fn figures(&self) -> Figures {
        let mut figures = Figures::default();
        if let (Some((_, first)), Some((_, last))) = (self.energies.first(), self.energies.last()) {
            add_energies(self, [first, last], &mut figures);
        }
        figures.plots.extend(restitution_by_rebound(self));
        figures.plots.extend(cooling(self));
        figures.plots.extend(discharge(self));
        figures.plots.extend(row_velocities(self));
        figures.plots.extend(overlap_over_time(self));
        figures.plots.extend(surface(self));
        figures.plots.extend(packing_by_height(self));
        figures.plots.extend(stress_by_height(self));
        let radius = match (self.config.radius_m, self.config.radius_m.range()) {
            (DiscRadius::Equal(radius), _) => format!("r = {} m", short_number(radius.get())),
            (_, (min, max)) => format!("r = {} to {} m", short_number(min), short_number(max)),
        };
        let caption = |count: &str, time: &str| format!("{count}, {radius}, t = {time} s");
        let size = box_text([self.config.width_m.get(), self.config.height_m.get()], "m");
        figures.plots.extend(pictures(&self.snapshots, "Discs", caption, &size));
        figures
    }
}

fn add_energies(run: &DemRun, [first, last]: [&DemEnergy; 2], figures: &mut Figures) {
    let series = |of: &dyn Fn(&DemEnergy) -> f64| -> Vec<(f64, f64)> {
        run.energies.iter().map(|(time, energy)| (*time, of(energy))).collect()
    };
    let residual = |energy: &DemEnergy| balance_j(energy) - balance_j(first);
    let axes = |label: &str, unit: &str| [Axis::linear("time", "s"), Axis::linear(label, unit)];
    figures.plots.push(energy_balance(run, first));
    // The denominator of `energy.residual_relative`.
    let supplied = supplied_j(first, last).abs();
    if supplied == 0.0 {
        return;
    }
    let (residual_name, supplied_name) = match last.entered_j {
        0.0 => ("residual", "energy at the start"),
        _ => ("energy-balance error", "(initial + inserted energy)"),
    };
    let curves = vec![
        Curve::line("energy-balance error", 0, series(&|energy| residual(energy) / supplied)),
        Curve::theory("conservation of energy", 6, run.energies.ends().map(|end| (end.0, 0.0))),
    ];
    let title = "Energy-balance error";
    let label = format!("{residual_name} / {supplied_name}");
    let drift = Plot::chart("energy_drift", title, axes(&label, ""), curves);
    figures.plots.push(drift);
    let shared = |stem: &str, title: &str, axes: [Axis; 2], of: &dyn Fn(&DemEnergy) -> f64| {
        SharedCurve::new(stem, title, axes, series(&|energy| of(energy) / supplied).into_iter())
    };
    let relative = axes(&format!("energy / {supplied_name}"), "");
    let label = format!("|{residual_name}| / {supplied_name}");
    let error = [Axis::linear("time", "s"), Axis::logarithmic(&label, "")];
    figures.comparisons = vec![
        shared("energy_total_by_run", "Mechanical energy", relative, &total_j),
        shared("energy_residual_by_run", "Energy-balance error", error, &|energy| {
            residual(energy).abs()
        }),
    ];
}

/// Where the energy is: areas that fill the energy that the run was given.
fn energy_balance(run: &DemRun, first: &DemEnergy) -> Plot {
    let times: Vec<f64> = run.energies.iter().map(|(time, _)| *time).collect();
    let amounts = |of: fn(&DemEnergy) -> f64| -> Vec<f64> {
        run.energies.iter().map(|(_, energy)| of(energy)).collect()
    };
    let friction = |energy: &DemEnergy| energy.friction_j + energy.rolling_j;
    let has_rolling = run.energies.iter().any(|(_, energy)| energy.rolling_j != 0.0);
    let friction_label = if has_rolling { "lost in friction, rolling" } else { "lost in friction" };
    let mut columns = vec![
        ("potential", 1, amounts(|energy| energy.gravitational_j)),
        ("kinetic", 0, amounts(|energy| energy.kinetic_j)),
        ("elastic", 4, amounts(|energy| energy.elastic_j)),
        (
            "lost in dashpots",
            3,
            amounts(|energy| energy.dissipated_j - energy.friction_j - energy.rolling_j),
        ),
        (friction_label, 2, amounts(friction)),
        ("left with discs", 5, amounts(|energy| energy.removed_j)),
    ];
    columns.retain(|(.., amounts)| amounts.iter().any(|amount| *amount != 0.0));
    let (mut curves, shifts) = stacked(&times, &columns);
    let last = run.energies.last().map(|(_, energy)| energy);
    let given = last.map_or_else(String::new, |last| {
        let inserted = if last.entered_j == 0.0 { "" } else { " + inserted" };
        let work = if last.wall_work_j == 0.0 { "" } else { " + work of walls" };
        format!("start{inserted}{work}")
    });
    let sum = |energy: &DemEnergy| total_j(first) + energy.entered_j + energy.wall_work_j + shifts;
    let sums = run.energies.iter().map(|(time, energy)| (*time, sum(energy)));
    curves.push(Curve::theory(given, 6, sums));
    let axes = [Axis::linear("time", "s"), Axis::linear("energy", "J")];
    Plot::chart("energy_balance", "Where the energy is", axes, curves)
}

/// The restitution of each rebound of a single disc, with that of the contact by theory.
fn restitution_by_rebound(run: &DemRun) -> Option<Plot> {
    let measured = run.known_rebounds()?.restitutions();
    let points = measured.iter().enumerate().map(|(index, value)| ((index + 1) as f64, *value));
    let mut curves = vec![Curve::new("measured", CurveStyle::Data, 0, points)];
    let theory = law::WallContact::of(&run.config)
        .filter(|_| !contact_constants::is_cohesive(&run.config))
        .map(|contact| contact.restitution().value);
    let ends = [1.0, measured.len() as f64];
    curves.extend(theory.map(|theory| Curve::theory("theory", 1, ends.map(|end| (end, theory)))));
    let axes = [Axis::linear("number of the rebound", ""), Axis::linear("restitution", "")];
    let title = "Restitution of each rebound";
    (!measured.is_empty()).then(|| Plot::chart("restitution_by_rebound", title, axes, curves))
}

/// Granular temperature over time with Haff's law, of discs without gravity and walls.
fn cooling(run: &DemRun) -> Option<Plot> {
    let (begin, first) = *run.temperature.first()?;
    if run.temperature.len() < 2 || !special_setups::is_free_gas(&run.config) {
        return None;
    }
    let mut curves = vec![Curve::line("measured", 0, run.temperature.iter().copied())];
    let is_hard = !contact_constants::is_cohesive(&run.config);
    if let Some(rate) = law::cooling_rate_per_s(&run.config, first).filter(|_| is_hard) {
        let haff = |time: f64| first / libm::pow(1.0 + rate.value * (time - begin), 2.0);
        let line = run.temperature.iter().map(|(time, _)| (*time, haff(*time)));
        curves.push(Curve::theory("Haff's law, T₀/(1 + t/τ)²", 1, line));
    }
    let axes = [Axis::linear("time", "s"), Axis::linear("granular temperature", "m²/s²")];
    Some(Plot::chart("cooling", "Granular temperature", axes, curves))
}

/// Number of removed discs over time with the fitted rate, and of inserted discs.
fn discharge(run: &DemRun) -> Option<Plot> {
    let (end, all) = *run.removed.last()?;
    let steady = special_setups::steady_part(&run.removed);
    if all == 0.0 {
        return None;
    }
    let mut curves = vec![Curve::line("left through the outlet", 0, run.removed.iter().copied())];
    let rate = special_setups::discharge_rate_per_s(&run.removed);
    if let (Some(rate), Some(first), Some(last)) = (rate, steady.first(), steady.last()) {
        let middle = ((first.0 + last.0) / 2.0, (first.1 + last.1) / 2.0);
        let line = [first.0, end].map(|time| (time, middle.1 + rate.value * (time - middle.0)));
        let name = format!("mean rate, {} per second", short_number(rate.value));
        curves.push(Curve::new(name, CurveStyle::Fit, 1, line));
    }
    if let Some(insertion) = &run.config.insertion {
        let per_second = insertion.discs_per_s.get();
        let filled = f64::from(insertion.discs.get()) / per_second;
        let line = [0.0, filled.min(end), end].map(|time| (time, per_second * time.min(filled)));
        curves.push(Curve::theory("inserted", 2, line));
    }
    let axes = [Axis::linear("time", "s"), Axis::linear("discs", "")];
    Some(Plot::chart("discharge", "Discs that have left", axes, curves))
}

/// Velocity of each disc of a row, with that of the last one by theory.
fn row_velocities(run: &DemRun) -> Option<Plot> {
    let all = &run.row_velocities;
    let (first, last) = (*all.first()?.first()?, *all.first()?.last()?);
    let curve = |(index, series): (usize, &Series<(f64, f64)>)| {
        Curve::line(format!("disc {}", index + 1), index, series.iter().copied())
    };
    let mut curves: Vec<Curve> = all.iter().enumerate().map(curve).collect();
    let theory = law::velocity_transmission(&run.config)
        .filter(|fraction| fraction.violation.is_none())
        .map(|fraction| fraction.value * first.1);
    curves.extend(theory.map(|velocity| {
        let ends = [first.0, last.0].map(|time| (time, velocity));
        let name = format!("disc {} at the end, by momentum and restitution", all.len());
        Curve::theory(name, all.len() - 1, ends)
    }));
    let axes = [Axis::linear("time", "s"), Axis::linear("velocity along the row", "m/s")];
    Some(Plot::chart("row_velocities", "Velocity of each disc of the row", axes, curves))
}

/// The largest overlap of each frame, which a time step that is too long makes large.
fn overlap_over_time(run: &DemRun) -> Option<Plot> {
    let overlaps: Vec<(f64, f64)> =
        run.overlaps.iter().copied().filter(|(_, overlap)| overlap.is_finite()).collect();
    let is_empty = overlaps.is_empty();
    let curves = vec![Curve::line("largest overlap", 0, overlaps)];
    let axes = [Axis::linear("time", "s"), Axis::linear("overlap / radius", "")];
    let title = "Largest overlap of two discs";
    (!is_empty).then(|| Plot::chart("overlap_over_time", title, axes, curves))
}

/// The surface of the bed at the end, with the lines through its flanks whose mean angle is that of the surface.
fn surface(run: &DemRun) -> Option<Plot> {
    let discs = run.discs_at_end().filter(|discs| discs.len() > 1 && run.is_bed(discs))?;
    let width = run.config.width_m.get();
    let surface = bed_shape::surface_points(&discs, width);
    let mut curves = vec![Curve::new("highest discs", CurveStyle::Data, 0, surface)];
    for (index, line) in bed_shape::flank_lines(&discs, width).into_iter().flatten().enumerate() {
        curves.push(Curve::theory(if index == 0 { "fitted flanks" } else { "" }, 1, line));
    }
    let axes = [Axis::linear("distance from the left wall", "m"), Axis::linear("height", "m")];
    Some(Plot::chart("surface", "Surface of the bed at the end", axes, curves))
}

/// Maximum number of slabs in the profile of the packing fraction; a slab is one mean diameter thick.
const MAX_SLABS: usize = 200;

/// Packing fraction of each slab of the box, from the floor to the highest disc.
fn packing_by_height(run: &DemRun) -> Option<Plot> {
    let discs = run.discs_at_end().filter(|discs| discs.len() > 1)?;
    let count = discs.len() as f64;
    let diameter = 2.0 * discs.iter().map(|disc| disc[2]).sum::<f64>() / count;
    let top = discs.iter().map(|disc| disc[1] + disc[2]).fold(0.0, f64::max);
    let slabs = ((top / diameter).ceil() as usize).clamp(1, MAX_SLABS);
    let thickness = top / slabs as f64;
    let mut covered = vec![0.0; slabs];
    for [_, height, radius, _] in discs {
        let first = ((height - radius) / thickness).max(0.0) as usize;
        for (slab, covered) in covered.iter_mut().enumerate().skip(first) {
            let [low, high] = [slab, slab + 1].map(|edge| edge as f64 * thickness - height);
            if low > radius {
                break;
            }
            *covered += area_below(high, radius) - area_below(low, radius);
        }
    }
    let slab_area = run.config.width_m.get() * thickness;
    let height = |slab: usize| (slab as f64 + 0.5) * thickness;
    let profile = covered.iter().enumerate().map(|(slab, area)| (height(slab), area / slab_area));
    let hexagonal = PI / 12.0_f64.sqrt();
    let level = [(0.0, hexagonal), (top, hexagonal)];
    let curves = vec![
        Curve::new("slabs of a mean diameter", CurveStyle::Data, 0, profile),
        Curve::theory("hexagonal packing of equal discs, 0.9069", 1, level),
    ];
    let axes = [Axis::linear("height over the floor", "m"), Axis::linear("packing fraction", "")];
    let title = "Packing fraction by height at the end";
    Some(Plot::chart("packing_by_height", title, axes, curves))
}

/// Vertical and horizontal stress by height, compared with the weight above.
fn stress_by_height(run: &DemRun) -> Option<Plot> {
    let layers = run.stress.as_ref()?.layers();
    let floor = layers.first()?;
    let data = |name: &str, color: usize, of: fn(&StressLayer) -> Estimate| {
        let points = layers.iter().map(|layer| {
            let Estimate { value, conditional_standard_error, .. } = of(layer);
            Point { x: layer.height_m, y: value, error: conditional_standard_error }
        });
        Curve { name: name.to_owned(), style: CurveStyle::Data, color, points: points.collect() }
    };
    let above = layers.iter().map(|layer| (layer.height_m, layer.weight_above));
    // A straight line with the same total weight: the integral of w (1 - y/h) is w h/2.
    let thickness = 2.0 * floor.height_m;
    let area = layers.iter().map(|layer| layer.weight_above * thickness).sum::<f64>();
    let weight = run.weight_over_width()?;
    let even = [(0.0, weight), (2.0 * area / weight, 0.0)];
    let curves = vec![
        data("vertical", 0, |layer| layer.vertical),
        data("horizontal", 1, |layer| Estimate::bare(layer.horizontal)),
        Curve::theory("weight of the discs above / width", 6, above),
        Curve::theory("mean density × gravity × depth, an even bed", 3, even),
    ];
    let axes = [Axis::linear("height over the floor", "m"), Axis::linear("stress", "N/m")];
    let title = "Stress by height, mean over the last tenth of the run";
    Some(Plot::chart("stress_by_height", title, axes, curves))
}

/// Area of the part of a disc below a horizontal line at this height above its center.
fn area_below(line: f64, radius: f64) -> f64 {
    let share = (line / radius).clamp(-1.0, 1.0);
    radius * radius * (PI / 2.0 + libm::asin(share) + share * (1.0 - share * share).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::snapshots::Snapshots;
    use crate::plot::PlotContent;
    use kinetoscope_manifest::model::DemConfig;

    /// Label of the vertical axis of the energy-balance error, and its last value.
    fn final_error(start_j: f64, entered_j: f64) -> (String, f64) {
        let mut run = DemRun::new(DemConfig::default(), Snapshots::default());
        let energy =
            |kinetic_j, entered_j| DemEnergy { kinetic_j, entered_j, ..DemEnergy::default() };
        run.energies.add((0.0, energy(start_j, 0.0)));
        run.energies.add((1.0, energy(start_j + entered_j - 0.5, entered_j)));
        let figures = run.figures();
        let drift = figures.plots.iter().find(|plot| plot.stem == "energy_drift").unwrap();
        let PlotContent::Chart(chart) = &drift.content else { panic!("no chart") };
        let shared = &figures.comparisons[1];
        assert_eq!(shared.points.last().unwrap().y, chart.curves[0].points[1].y.abs());
        (chart.y.label.clone(), chart.curves[0].points[1].y)
    }

    /// Guarantee: the error is relative to the energy that the run was given, as `energy.residual_relative` is. Setup: 0.5 J of 100 J
    /// are lost, of which 1 J or all was there at the start.
    #[test]
    fn energy_balance_error_is_relative_to_the_initial_and_the_inserted_energy() {
        let (label, error) = final_error(1.0, 99.0);
        assert_eq!(
            (label.as_str(), error),
            ("energy-balance error / (initial + inserted energy)", -0.005)
        );
        let (label, error) = final_error(100.0, 0.0);
        assert_eq!((label.as_str(), error), ("residual / energy at the start", -0.005));
        assert_eq!(final_error(0.0, 100.0).1, -0.005, "an empty box at the start");
    }

    #[test]
    fn the_area_below_a_line_is_that_of_the_segment() {
        assert!((area_below(2.0, 2.0) - 4.0 * PI).abs() < 1e-14);
        assert!(area_below(-3.0, 2.0).abs() < 1e-14);
        assert!((area_below(0.0, 2.0) - 2.0 * PI).abs() < 1e-14);
        // A circular segment of height r/2: r^2 (pi/3 - sqrt(3)/4).
        let segment = PI / 3.0 - 3.0_f64.sqrt() / 4.0;
        assert!((area_below(-0.5, 1.0) - segment).abs() < 1e-14);
    }
}
