//! Plots of orbits: paths, energy and position error over time.

use super::bodies::{BodiesRun, SystemState};
use super::laws as law;
use super::observe::{OrbitPoint, OrbitRun};
use crate::models::contract::{NamedChart, PlottedObserver};
use crate::models::figures::{Figures, SharedCurve};
use crate::models::series::Series;
use crate::models::{max_or_nan, relative_change};
use crate::plot::{Axis, Chart, Curve, CurveStyle, Plot, PlotContent, Point};
use kinetoscope_manifest::model::OrbitIntegrator;

/// The charts that a plot may name.
pub(super) const CHARTS: &[NamedChart] = &[
    NamedChart::of_all_states("path", &["radius.min", "radius.max", "position_error.final"]),
    NamedChart::of_all_states("energy_drift", ENERGY_ERRORS),
    NamedChart::of_all_states("energy_error_by_run", ENERGY_ERRORS),
    NamedChart::of_all_states("position_error", &["position_error.final"]),
    NamedChart::of_all_states("position_error_by_run", &["position_error.final"]),
    NamedChart::of_all_states(
        "semi_major_axis",
        &[
            "semi_major_axis.growth_relative",
            "energy.drift_relative",
            "radius.max",
            "semi_major_axis",
        ],
    ),
    NamedChart::of_all_states("distance_from_start", &["period.measured", "position_error.final"]),
    NamedChart::of_all_states("return_distance_by_run", &["return_distance.final"]),
    NamedChart::of_all_states("angle_by_run", &["return_distance.final"]),
    NamedChart::of_all_states("rotating_frame", &["return_distance.final"]),
    NamedChart::of_all_states("closest_approach", &["closest_approach", "closest_approach.time"]),
];

const ENERGY_ERRORS: &[&str] =
    &["energy.drift_relative", "energy.max_error_relative", "energy.drift_per_revolution"];

impl PlottedObserver for OrbitRun {
    fn figures(&self) -> Figures {
        let Some(first) = self.points.first() else { return Figures::default() };
        let curves = vec![
            path("Earth", 0, &self.points, 6000, |point| point.position_au),
            Curve::new("Sun", CurveStyle::Data, 5, [(0.0, 0.0)]),
        ];
        let path = path_chart("Path about the Sun", curves);
        let axis = semi_major_axis(self);
        let plots = [Some(path), axis, Some(distance_from_start(self, first))];
        let plots = plots.into_iter().flatten();
        Figures {
            plots: plots.chain([energy(self, first), position_error(self)]).collect(),
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
        Figures { plots: plots.into_iter().flatten().collect(), comparisons: shared(self, first) }
    }
}

/// Curves of several bodies that runs share: energy error, largest distance of a body from its start, and angle from the planet.
fn shared(run: &BodiesRun, first: &SystemState) -> Vec<SharedCurve> {
    let over_instants = |of: &dyn Fn(&SystemState) -> f64| -> Vec<(f64, f64)> {
        run.instants.iter().map(|instant| (instant.time_days, of(instant))).collect()
    };
    let errors = over_instants(&|instant| relative_change(instant.energy, first.energy).abs());
    let away = over_instants(&|instant| {
        let pairs = instant.positions.iter().zip(&first.positions);
        let distances = pairs.map(|(now, start)| law::norm(law::difference(*now, *start)));
        distances.fold(0.0, max_or_nan)
    });
    let error_axes = over_time(Axis::logarithmic("|E − E₀| / |E₀|", ""));
    let away_axes = over_time(Axis::linear("largest distance of a body from its start", "AU"));
    let [title, return_title] = ["Size of the energy error", "Distance from the start"];
    let mut curves = vec![
        SharedCurve::new("energy_error_by_run", title, error_axes, errors.into_iter()),
        SharedCurve::new("return_distance_by_run", return_title, away_axes, away.into_iter()),
    ];
    if let Some(frame) = &run.rotating_frame
        && let Some(body) = frame.companions.first()
    {
        let mut turns = 0.0;
        let mut before: Option<f64> = None;
        // The angle is continued over half a turn.
        let angles: Vec<(f64, f64)> = over_instants(&|instant| {
            let (x, y) = frame.position(&instant.positions, *body);
            libm::atan2(y, x).to_degrees()
        })
        .into_iter()
        .map(|(time, angle)| {
            turns -= before.map_or(0.0, |before| libm::round((angle - before) / 360.0));
            before = Some(angle);
            (time, angle + 360.0 * turns)
        })
        .collect();
        let axes = over_time(Axis::linear("angle ahead of the planet", "degrees"));
        let title = "Angle between a companion and the planet";
        curves.push(SharedCurve::new("angle_by_run", title, axes, angles.into_iter()));
    }
    curves
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

/// The semi-major axis of explicit Euler, which grows, with its law.
fn semi_major_axis(run: &OrbitRun) -> Option<Plot> {
    let orbit = run.exact.filter(|_| run.config.integrator == OrbitIntegrator::ExplicitEuler)?;
    let axis = |point: &OrbitPoint| -law::GM_SUN_AU3_PER_DAY2 / (2.0 * point.energy);
    let bound = || run.points.iter().filter(|point| point.energy < 0.0);
    let mut curves =
        vec![Curve::line("measured", 0, bound().map(|point| (point.time_days, axis(point))))];
    let step = run.config.time_step_days.get();
    let end = run.points.last().map_or(0.0, |point| point.time_days);
    if law::outside_euler_range(step, &orbit, end).is_none() {
        let at = |time: f64| {
            orbit.semi_major_axis_au / (1.0 - law::euler_energy_drift(step, &orbit, time))
        };
        let line = bound().map(|point| (point.time_days, at(point.time_days)));
        curves.push(Curve::theory("(a₀³ + 6 Δt GM t)^(1/3)", 1, line));
    }
    let axes = over_time(Axis::linear("semi-major axis", "AU"));
    Some(Plot::chart("semi_major_axis", "Growth of the orbit", axes, curves))
}

/// Distance from the first position: 0 again after each period of a closed orbit.
fn distance_from_start(run: &OrbitRun, first: &OrbitPoint) -> Plot {
    let away =
        |point: &OrbitPoint| law::norm(law::difference(point.position_au, first.position_au));
    let measured = run.points.iter().map(|point| (point.time_days, away(point)));
    let mut curves = vec![Curve::line("distance from the start", 0, measured)];
    if let Some(orbit) = run.exact {
        let end = run.points.last().map_or(0.0, |point| point.time_days);
        let revolutions = (end / orbit.period_days()).floor().min(100.0) as u32;
        let periods = (1..=revolutions).map(|turn| (f64::from(turn) * orbit.period_days(), 0.0));
        let name = format!("Kepler's period, {:.2} days", orbit.period_days());
        if revolutions > 0 {
            curves.push(Curve::new(name, CurveStyle::Data, 1, periods));
        }
    }
    let axes = over_time(Axis::linear("distance from the start", "AU"));
    Plot::chart("distance_from_start", "Return to the start", axes, curves)
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
                curves.push(Curve::theory(
                    "first-order theory, 1 − (1 + 6 Δt ω² t)^(−1/3)",
                    1,
                    line,
                ));
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
