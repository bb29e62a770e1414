//! Plots of a DEM run: energy balance, packing fraction and stress by height, snapshots.

use super::observe::{DemRun, EnergyBalance};
use super::stress::StressLayer;
use crate::models::contract::PlottedObserver;
use crate::models::figures::{Figures, SharedCurve, box_text, chart, curve, pictures};
use crate::plot::{Axis, Curve, CurveStyle, Plot, Point, short_number, thinned};
use crate::statistics::Estimate;
use kinetoscope_manifest::model::DiscRadius;
use std::f64::consts::PI;

impl PlottedObserver for DemRun {
    fn figures(&self) -> Figures {
        let run = self;
        let mut figures = Figures::default();
        if let Some(first) = run.energy_balance.first() {
            figures.plots.push(energy_balance(run));
            let start = first.total_j().abs();
            if start > 0.0 {
                figures.plots.push(residual(run, start));
                figures.comparisons = comparisons(run, start);
            }
        }
        figures.plots.extend(packing_by_height(run));
        figures.plots.extend(stress_by_height(run));
        figures.plots.extend(states(run));
        figures
    }
}

fn energy_balance(run: &DemRun) -> Plot {
    let first = run.energy_balance.first().map_or(0.0, |entry| entry.balance_j());
    let series = |of: fn(&EnergyBalance) -> f64| {
        run.energy_balance.iter().map(move |entry| (entry.time_s, of(entry)))
    };
    let residual = run.energy_balance.iter().map(|entry| (entry.time_s, entry.balance_j() - first));
    let curves = vec![
        curve("kinetic", CurveStyle::Line, 0, series(|entry| entry.kinetic_j)),
        curve("gravitational", CurveStyle::Line, 1, series(|entry| entry.gravitational_j)),
        curve("elastic", CurveStyle::Line, 2, series(|entry| entry.elastic_j)),
        curve("dissipated", CurveStyle::Line, 3, series(|entry| entry.dissipated_j)),
        curve(
            "sum at the start",
            CurveStyle::Theory,
            6,
            series(|_| 0.0).map(|(time, _)| (time, first)),
        ),
        curve("residual", CurveStyle::Line, 5, residual),
    ];
    let (x, y) = (Axis::linear("time", "s"), Axis::linear("energy", "J"));
    chart("energy_balance", "Energy balance", x, y, curves)
}

fn residual(run: &DemRun, start: f64) -> Plot {
    let first = run.energy_balance.first().map_or(0.0, |entry| entry.balance_j());
    let drift =
        run.energy_balance.iter().map(|entry| (entry.time_s, (entry.balance_j() - first) / start));
    let ends = [run.energy_balance.first(), run.energy_balance.last()];
    let theory = ends.into_iter().flatten().map(|entry| (entry.time_s, 0.0));
    let curves = vec![
        curve("energy-balance error", CurveStyle::Line, 0, drift),
        curve("conservation of energy", CurveStyle::Theory, 6, theory),
    ];
    let y = Axis::linear("residual / energy at the start", "");
    let title = "Energy that the integrator gains or loses";
    chart("energy_drift", title, Axis::linear("time", "s"), y, curves)
}

fn comparisons(run: &DemRun, start: f64) -> Vec<SharedCurve> {
    let first = run.energy_balance.first().map_or(0.0, |entry| entry.balance_j());
    let points = |of: &dyn Fn(&EnergyBalance) -> f64| {
        let points =
            run.energy_balance.iter().map(|entry| Point::bare(entry.time_s, of(entry) / start));
        thinned(points.collect(), crate::models::figures::MAX_POINTS)
    };
    vec![
        SharedCurve {
            stem: "energy_total_by_run".to_owned(),
            title: "Mechanical energy".to_owned(),
            x: Axis::linear("time", "s"),
            y: Axis::linear("energy / energy at the start", ""),
            points: points(&|entry| entry.total_j()),
        },
        SharedCurve {
            stem: "energy_residual_by_run".to_owned(),
            title: "Energy-balance error".to_owned(),
            x: Axis::linear("time", "s"),
            y: Axis::logarithmic("|residual| / energy at the start", ""),
            points: points(&|entry| (entry.balance_j() - first).abs()),
        },
    ]
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
    let profile = covered
        .iter()
        .enumerate()
        .map(|(slab, area)| ((slab as f64 + 0.5) * thickness, area / slab_area));
    let measured = curve("slabs of a mean diameter", CurveStyle::Data, 0, profile);
    let hexagonal = PI / 12.0_f64.sqrt();
    let level = [(0.0, hexagonal), (top, hexagonal)];
    let closest = curve("hexagonal packing of equal discs, 0.9069", CurveStyle::Theory, 1, level);
    let (x, y) = (Axis::linear("height over the floor", "m"), Axis::linear("packing fraction", ""));
    let title = "Packing fraction by height at the end";
    Some(chart("packing_by_height", title, x, y, vec![measured, closest]))
}

/// Vertical and horizontal stress by height, compared with the weight above.
fn stress_by_height(run: &DemRun) -> Option<Plot> {
    let layers = run.stress.as_ref()?.layers();
    let floor = layers.first()?;
    let points = |of: fn(&StressLayer) -> Estimate| {
        let points = layers.iter().map(|layer| {
            let Estimate { value, standard_error } = of(layer);
            Point { x: layer.height_m, y: value, error: standard_error }
        });
        points.collect::<Vec<Point>>()
    };
    let data = |name: &str, color: usize, of: fn(&StressLayer) -> Estimate| Curve {
        name: name.to_owned(),
        style: CurveStyle::Data,
        color,
        points: points(of),
    };
    let above = layers.iter().map(|layer| (layer.height_m, layer.weight_above));
    // A straight line with the same total weight: the integral of w (1 - y/h) is w h/2.
    let thickness = 2.0 * floor.height_m;
    let area = layers.iter().map(|layer| layer.weight_above * thickness).sum::<f64>();
    let weight = run.weight_over_width()?;
    let even = [(0.0, weight), (2.0 * area / weight, 0.0)];
    let curves = vec![
        data("vertical", 0, |layer| layer.vertical),
        data("horizontal", 1, |layer| layer.horizontal),
        curve("weight of the discs above / width", CurveStyle::Theory, 6, above),
        curve("rho g (h - y), an even bed", CurveStyle::Theory, 3, even),
    ];
    let (x, y) = (Axis::linear("height over the floor", "m"), Axis::linear("stress", "N/m"));
    let title = "Stress by height, mean over the last tenth of the run";
    Some(chart("stress_by_height", title, x, y, curves))
}

/// Area of the part of a disc below a horizontal line at this height above its center.
fn area_below(line: f64, radius: f64) -> f64 {
    let share = (line / radius).clamp(-1.0, 1.0);
    radius * radius * (PI / 2.0 + share.asin() + share * (1.0 - share * share).sqrt())
}

fn states(run: &DemRun) -> Vec<Plot> {
    let radius = match (run.config.radius_m, run.config.radius_m.range()) {
        (DiscRadius::Equal(radius), _) => format!("r = {} m", short_number(radius.get())),
        (_, (min, max)) => format!("r = {} to {} m", short_number(min), short_number(max)),
    };
    let caption = |count: &str, time: &str| format!("{count}, {radius}, t = {time} s");
    let size = box_text([run.config.width_m.get(), run.config.height_m.get()], "m");
    pictures(&run.snapshots, "Discs", caption, &size)
}

#[cfg(test)]
mod tests {
    use super::*;

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
