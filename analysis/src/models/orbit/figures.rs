//! Plots of an orbit: path around the Sun, energy and position error over time.

use super::laws as law;
use super::observe::{OrbitPoint, OrbitRun};
use crate::models::contract::PlottedObserver;
use crate::models::figures::{Figures, SharedCurve, chart, curve};
use crate::plot::{Axis, Chart, Curve, CurveStyle, Plot, Point, thinned};
use kinetoscope_manifest::model::OrbitIntegrator;

impl PlottedObserver for OrbitRun {
    fn figures(&self) -> Figures {
        let run = self;
        let Some(first) = run.points.first() else { return Figures::default() };
        Figures {
            plots: vec![path(run), energy(run, first), position_error(run)],
            comparisons: comparisons(run, first),
        }
    }
}

fn time_axis() -> Axis {
    Axis::linear("time", "days")
}

fn path(run: &OrbitRun) -> Plot {
    // A closed path is thinned evenly, because its extremes are not those of its neighbors.
    let stride = run.points.len().div_ceil(6000);
    let points = run.points.iter().step_by(stride.max(1));
    let points = points.map(|point| Point::bare(point.position_au[0], point.position_au[1]));
    let earth = Curve {
        name: "Earth".to_owned(),
        style: CurveStyle::Line,
        color: 0,
        points: points.collect(),
    };
    Plot::Chart(Chart {
        stem: "path".to_owned(),
        title: "Path about the Sun".to_owned(),
        x: Axis::linear("x", "AU"),
        y: Axis::linear("y", "AU"),
        equal_aspect: true,
        curves: vec![earth, curve("Sun", CurveStyle::Data, 5, [(0.0, 0.0)])],
    })
}

fn drift(point: &OrbitPoint, first: &OrbitPoint) -> f64 {
    (point.energy - first.energy) / first.energy.abs()
}

fn energy(run: &OrbitRun, first: &OrbitPoint) -> Plot {
    let measured = run.points.iter().map(|point| (point.time_days, drift(point, first)));
    let mut curves = vec![curve("measured", CurveStyle::Line, 0, measured)];
    let step = run.config.time_step_days.get();
    let theory = |time: f64| match (run.config.integrator, &run.exact) {
        (OrbitIntegrator::ExplicitEuler, Some(orbit)) => law::euler_energy_drift(step, orbit, time),
        _ => 0.0,
    };
    let name = match run.config.integrator {
        OrbitIntegrator::ExplicitEuler => "theory: 1 − (1 + 6 h n² t)^(−1/3)",
        _ => "exact",
    };
    let line = run.points.iter().map(|point| (point.time_days, theory(point.time_days)));
    curves.push(curve(name, CurveStyle::Theory, 1, line));
    let y = Axis::linear("(E − E₀) / |E₀|", "");
    chart("energy_drift", "Energy of the orbit", time_axis(), y, curves)
}

fn position_error(run: &OrbitRun) -> Plot {
    let measured = run.points.iter().map(|point| (point.time_days, point.position_error_au));
    let curves = vec![curve("distance from the Kepler solution", CurveStyle::Line, 0, measured)];
    let y = Axis::logarithmic("position error", "AU");
    chart("position_error", "Error of the position", time_axis(), y, curves)
}

fn comparisons(run: &OrbitRun, first: &OrbitPoint) -> Vec<SharedCurve> {
    let points = |of: &dyn Fn(&OrbitPoint) -> f64| {
        let points = run.points.iter().map(|point| Point::bare(point.time_days, of(point)));
        thinned(points.collect(), crate::models::figures::MAX_POINTS)
    };
    vec![
        SharedCurve {
            stem: "energy_error_by_run".to_owned(),
            title: "Size of the energy error".to_owned(),
            x: time_axis(),
            y: Axis::logarithmic("|E − E₀| / |E₀|", ""),
            points: points(&|point| drift(point, first).abs()),
        },
        SharedCurve {
            stem: "position_error_by_run".to_owned(),
            title: "Distance from the exact position".to_owned(),
            x: time_axis(),
            y: Axis::logarithmic("position error", "AU"),
            points: points(&|point| point.position_error_au),
        },
    ]
}
