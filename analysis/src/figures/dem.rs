//! Plots of a DEM run: the energy ledger over time and the discs at the end.

use super::{Comparison, Figures, chart, count_text, curve};
use crate::observables::dem::{DemRun, Ledger};
use crate::plot::{Axis, Container, Picture, Plot, Point, Style, short_number, thinned};
use kinetoscope_manifest::model::DiscRadius;

/// All plots of a run.
#[must_use]
pub fn figures(run: &DemRun) -> Figures {
    let mut figures = Figures::default();
    if let Some(first) = run.ledger.first() {
        figures.plots.push(ledger(run));
        let start = first.total_j().abs();
        if start > 0.0 {
            figures.plots.push(residual(run, start));
            figures.comparisons = comparisons(run, start);
        }
    }
    if !run.snapshot.bodies.is_empty() {
        figures.plots.push(Plot::Picture(state(run)));
    }
    figures
}

fn ledger(run: &DemRun) -> Plot {
    let first = run.ledger.first().map_or(0.0, |entry| entry.balance_j());
    let series =
        |of: fn(&Ledger) -> f64| run.ledger.iter().map(move |entry| (entry.time_s, of(entry)));
    let residual = run.ledger.iter().map(|entry| (entry.time_s, entry.balance_j() - first));
    let curves = vec![
        curve("kinetic", Style::Line, 0, series(|entry| entry.kinetic_j)),
        curve("gravitational", Style::Line, 1, series(|entry| entry.gravitational_j)),
        curve("elastic", Style::Line, 2, series(|entry| entry.elastic_j)),
        curve("dissipated", Style::Line, 3, series(|entry| entry.dissipated_j)),
        curve("sum at the start", Style::Theory, 6, series(|_| 0.0).map(|(time, _)| (time, first))),
        curve("residual", Style::Line, 5, residual),
    ];
    let (x, y) = (Axis::linear("time", "s"), Axis::linear("energy", "J"));
    chart("energy_ledger", "Energy ledger", x, y, curves)
}

fn residual(run: &DemRun, start: f64) -> Plot {
    let first = run.ledger.first().map_or(0.0, |entry| entry.balance_j());
    let drift = run.ledger.iter().map(|entry| (entry.time_s, (entry.balance_j() - first) / start));
    let ends = [run.ledger.first(), run.ledger.last()];
    let theory = ends.into_iter().flatten().map(|entry| (entry.time_s, 0.0));
    let curves = vec![
        curve("residual of the ledger", Style::Line, 0, drift),
        curve("conservation of energy", Style::Theory, 6, theory),
    ];
    let y = Axis::linear("residual / energy at the start", "");
    let title = "Energy that the integrator gains or loses";
    chart("energy_drift", title, Axis::linear("time", "s"), y, curves)
}

fn comparisons(run: &DemRun, start: f64) -> Vec<Comparison> {
    let first = run.ledger.first().map_or(0.0, |entry| entry.balance_j());
    let points = |of: &dyn Fn(&Ledger) -> f64| {
        let points = run.ledger.iter().map(|entry| Point::bare(entry.time_s, of(entry) / start));
        thinned(points.collect(), super::MOST_POINTS)
    };
    vec![
        Comparison {
            stem: "energy_total_by_run",
            title: "Mechanical energy",
            x: Axis::linear("time", "s"),
            y: Axis::linear("energy / energy at the start", ""),
            points: points(&|entry| entry.total_j()),
        },
        Comparison {
            stem: "energy_residual_by_run",
            title: "Size of the ledger's residual",
            x: Axis::linear("time", "s"),
            y: Axis::logarithmic("|residual| / energy at the start", ""),
            points: points(&|entry| (entry.balance_j() - first).abs()),
        },
    ]
}

fn state(run: &DemRun) -> Picture {
    let radius = match (run.config.radius_m, run.config.radius_m.range()) {
        (DiscRadius::Equal(radius), _) => format!("r = {} m", short_number(radius.get())),
        (_, (min, max)) => format!("r = {} to {} m", short_number(min), short_number(max)),
    };
    let count = count_text(run.snapshot.particles, run.snapshot.bodies.len());
    Picture {
        stem: "state_at_end".to_owned(),
        title: "Discs at the end".to_owned(),
        caption: format!("{count}, {radius}, t = {} s", short_number(run.snapshot.time)),
        length_unit: "m".to_owned(),
        speed_unit: "m/s".to_owned(),
        container: Container::Rectangle(
            [0.0, 0.0],
            [run.config.width_m.get(), run.config.height_m.get()],
        ),
        bodies: run.snapshot.bodies.clone(),
    }
}
