//! Plots of orbits: paths, energy and position error over time.

use super::bodies::BodiesRun;
use super::laws as law;
use super::observe::{OrbitPoint, OrbitRun};
use crate::models::contract::PlottedObserver;
use crate::models::figures::{Figures, SharedCurve};
use crate::models::relative_change;
use crate::models::series::Series;
use crate::plot::{Axis, Chart, Curve, CurveStyle, Plot, PlotContent, Point};
use kinetoscope_manifest::model::OrbitIntegrator;

impl PlottedObserver for OrbitRun {
    fn figures(&self) -> Figures {
        let Some(first) = self.points.first() else { return Figures::default() };
        let curves = vec![
            path("Earth", 0, &self.points, 6000, |point| point.position_au),
            Curve::new("Sun", CurveStyle::Data, 5, [(0.0, 0.0)]),
        ];
        let path = path_chart("Path about the Sun", curves);
        Figures {
            plots: vec![path, energy(self, first), position_error(self)],
            comparisons: comparisons(self, first),
        }
    }
}

impl PlottedObserver for BodiesRun {
    fn figures(&self) -> Figures {
        let Some(first) = self.instants.first() else { return Figures::default() };
        let paths = (0..first.positions.len()).map(|body| {
            let name = format!("body {body}");
            path(&name, body, &self.instants, 2000, |instant| instant.positions[body])
        });
        let path = path_chart("Paths about the center of mass", paths.collect());
        let drifts = self
            .instants
            .iter()
            .map(|instant| (instant.time_days, relative_change(instant.energy, first.energy)));
        let curves = vec![Curve::line("measured", 0, drifts)];
        let axes = over_time(Axis::linear("(E − E₀) / |E₀|", ""));
        let energy = Plot::chart("energy_drift", "Energy of all bodies", axes, curves);
        let plots = [Some(path), rotating_frame(self), separation(self), Some(energy)];
        Figures { plots: plots.into_iter().flatten().collect(), comparisons: Vec::new() }
    }
}

/// Paths in the frame that turns with a planet, with the points of equilibrium at 60 degrees.
fn rotating_frame(run: &BodiesRun) -> Option<Plot> {
    let frame = run.rotating_frame.as_ref()?;
    let first = run.instants.first()?;
    let (distance, _) = frame.position(&first.positions, frame.planet);
    let (cosine, sine) = (0.5 * distance, 0.75_f64.sqrt() * distance);
    let mark = |body: usize, place: (f64, f64)| {
        Curve::new(format!("body {body}"), CurveStyle::Data, body, [place])
    };
    // Marks first: a body that stays at a point of equilibrium is drawn on top of it.
    let mut curves = vec![
        mark(frame.central, (0.0, 0.0)),
        mark(frame.planet, (distance, 0.0)),
        Curve::new("L₄ and L₅", CurveStyle::Data, 5, [(cosine, sine), (cosine, -sine)]),
    ];
    curves.extend(frame.companions.iter().map(|body| {
        let path = run.instants.iter().map(|instant| frame.position(&instant.positions, *body));
        let points = path.map(|(x, y)| Point::bare(x, y)).collect();
        Curve { name: format!("body {body}"), style: CurveStyle::Line, color: *body, points }
    }));
    let title = format!("Frame that turns with body {}", frame.planet);
    let Plot { title, content, .. } = path_chart(&title, curves);
    Some(Plot { stem: "rotating_frame".to_owned(), title, content })
}

/// Separation of the pair with the closest approach.
fn separation(run: &BodiesRun) -> Option<Plot> {
    let closest = run.closest.as_ref()?;
    let [one, other] =
        [closest.first_body, closest.second_body].map(|body| usize::try_from(body).ok());
    let (one, other) = one.zip(other)?;
    let distances = run.instants.iter().filter_map(|instant| {
        let positions = [instant.positions.get(other)?, instant.positions.get(one)?];
        let separation = law::difference(*positions[0], *positions[1]);
        Some((instant.time_days, law::norm(separation)))
    });
    let least = [(closest.time_d, closest.separation_au)];
    let curves = vec![
        Curve::line(format!("bodies {one} and {other}"), 0, distances),
        Curve::new("closest approach", CurveStyle::Data, 1, least),
    ];
    let axes = over_time(Axis::linear("separation", "AU"));
    Some(Plot::chart("closest_approach", "The pair that comes closest", axes, curves))
}

/// The path of a body in the x-y plane. A closed path is thinned evenly, because its extremes are not those of its
/// neighbors.
fn path<T>(
    name: &str,
    color: usize,
    series: &Series<T>,
    most: usize,
    position: impl Fn(&T) -> [f64; 3],
) -> Curve {
    let stride = series.len().div_ceil(most).max(1);
    let positions = series.iter().step_by(stride).map(position);
    let points = positions.map(|[x, y, _]| Point::bare(x, y)).collect();
    Curve { name: name.to_owned(), style: CurveStyle::Line, color, points }
}

fn path_chart(title: &str, curves: Vec<Curve>) -> Plot {
    let [x, y] = ["x", "y"].map(|label| Axis::linear(label, "AU"));
    let content =
        PlotContent::Chart(Chart { x, y, equal_aspect: true, curves, remark: String::new() });
    Plot { stem: "path".to_owned(), title: title.to_owned(), content }
}

fn over_time(y: Axis) -> [Axis; 2] {
    [Axis::linear("time", "days"), y]
}

fn energy(run: &OrbitRun, first: &OrbitPoint) -> Plot {
    let drift = |point: &OrbitPoint| relative_change(point.energy, first.energy);
    let measured = run.points.iter().map(|point| (point.time_days, drift(point)));
    let mut curves = vec![Curve::line("measured", 0, measured)];
    let step = run.config.time_step_days.get();
    let end = run.points.last().map_or(0.0, |point| point.time_days);
    let times = run.points.iter().map(|point| point.time_days);
    match (run.config.integrator, &run.exact) {
        (OrbitIntegrator::ExplicitEuler, Some(orbit)) => {
            if law::outside_euler_range(step, orbit, end).is_none() {
                let line = times.map(|time| (time, law::euler_energy_drift(step, orbit, time)));
                curves.push(Curve::theory("theory: 1 − (1 + 6 Δt ω² t)^(−1/3)", 1, line));
            }
        }
        (OrbitIntegrator::ExplicitEuler, None) => {}
        _ => curves.push(Curve::theory("exact", 1, times.map(|time| (time, 0.0)))),
    }
    let axes = over_time(Axis::linear("(E − E₀) / |E₀|", ""));
    Plot::chart("energy_drift", "Energy of the orbit", axes, curves)
}

fn position_errors(run: &OrbitRun) -> impl Iterator<Item = (f64, f64)> {
    run.points.iter().map(|point| (point.time_days, point.position_error_au))
}

fn position_error(run: &OrbitRun) -> Plot {
    let curves = vec![Curve::line("distance from the Kepler solution", 0, position_errors(run))];
    let axes = over_time(Axis::logarithmic("position error", "AU"));
    Plot::chart("position_error", "Error of the position", axes, curves)
}

fn comparisons(run: &OrbitRun, first: &OrbitPoint) -> Vec<SharedCurve> {
    let error = |point: &OrbitPoint| relative_change(point.energy, first.energy).abs();
    let energies = run.points.iter().map(|point| (point.time_days, error(point)));
    let energy_axes = over_time(Axis::logarithmic("|E − E₀| / |E₀|", ""));
    let position_axes = over_time(Axis::logarithmic("position error", "AU"));
    let title = "Distance from the exact position";
    vec![
        SharedCurve::new("energy_error_by_run", "Size of the energy error", energy_axes, energies),
        SharedCurve::new("position_error_by_run", title, position_axes, position_errors(run)),
    ]
}
