//! What is seen of an orbit: energy, angular momentum, and the distance from the exact solution, all from `/state`.

use super::dem::largest_or_nan;
use super::{Observer, relative_change};
use crate::figures::{self, Figures};
use crate::laws::Law;
use crate::laws::orbit::{self as law, GM_SUN_AU3_PER_DAY2, KeplerOrbit, cross, dot, norm};
use crate::measurement::Measurement;
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator};
use kinetoscope_recording::channels::OrbitElements;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::TAU;

/// The planet at one instant, and how far it is from the exact solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// Simulated time, days.
    pub time_days: f64,
    /// Position, AU.
    pub position_au: [f64; 3],
    /// Energy of a unit mass, AU^2/day^2.
    pub energy: f64,
    /// r x v, AU^2/day.
    pub angular_momentum: [f64; 3],
    /// v x (r x v) / GM - r/|r|.
    pub eccentricity_vector: [f64; 3],
    /// Distance from the exact position, AU; not a number where the orbit is no ellipse.
    pub position_error_au: f64,
    /// Angle in the plane of the start minus the exact one, continuous from frame to frame, rad.
    pub phase_error_rad: f64,
}

/// An orbit while its frames go by.
#[derive(Clone, Debug)]
pub struct OrbitRun {
    pub(crate) config: OrbitConfig,
    pub(crate) exact: Option<KeplerOrbit>,
    pub(crate) stations: Vec<Station>,
    force_evaluations: Option<u64>,
    /// Unit vectors of the plane of the start: along r0, and across it in the sense of motion.
    plane: [[f64; 3]; 2],
}

impl OrbitRun {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(config: OrbitConfig) -> Self {
        Self {
            config,
            exact: None,
            stations: Vec::new(),
            force_evaluations: None,
            plane: [[0.0; 3]; 2],
        }
    }

    fn begin(&mut self, position: [f64; 3], velocity: [f64; 3]) {
        self.exact = KeplerOrbit::through(position, velocity);
        let along = position.map(|component| component / norm(position));
        let across = cross(cross(position, velocity), along);
        self.plane = [along, across.map(|component| component / norm(across))];
    }

    fn angle(&self, position: [f64; 3]) -> f64 {
        dot(position, self.plane[1]).atan2(dot(position, self.plane[0]))
    }

    fn station(&self, time_days: f64, position: [f64; 3], velocity: [f64; 3]) -> Station {
        let radius = norm(position);
        let angular_momentum = cross(position, velocity);
        let turned = cross(velocity, angular_momentum);
        let exact = self.exact.map(|orbit| orbit.position_au(time_days));
        let position_error_au = exact.map_or(f64::NAN, |exact| {
            norm(std::array::from_fn(|axis| position[axis] - exact[axis]))
        });
        let phase_error_rad = exact.map_or(f64::NAN, |exact| {
            let apart = self.angle(position) - self.angle(exact);
            let before = self.stations.last().map_or(0.0, |station| station.phase_error_rad);
            // Between two frames the error changes by less than half a turn.
            apart + TAU * ((before - apart) / TAU).round()
        });
        Station {
            time_days,
            position_au: position,
            energy: dot(velocity, velocity) / 2.0 - GM_SUN_AU3_PER_DAY2 / radius,
            angular_momentum,
            eccentricity_vector: std::array::from_fn(|axis| {
                turned[axis] / GM_SUN_AU3_PER_DAY2 - position[axis] / radius
            }),
            position_error_au,
            phase_error_rad,
        }
    }

    fn energy_measurements(&self, first: &Station, last: &Station, found: &mut Vec<Measurement>) {
        let step = self.config.time_step_days.get();
        let integrator = self.config.integrator;
        let euler = integrator == OrbitIntegrator::ExplicitEuler;
        let orbit = self.exact.as_ref();
        let drift = relative_change(last.energy, first.energy);
        let theory: Option<(f64, Law)> = match (integrator, orbit) {
            (OrbitIntegrator::ExplicitEuler, Some(orbit)) => {
                Some((law::euler_energy_drift(step, orbit, last.time_days), law::EULER_ENERGY))
            }
            (OrbitIntegrator::Kepler, _) => Some((0.0, law::ENERGY)),
            _ => None,
        };
        let (theory, source) =
            theory.map_or((None, law::ENERGY), |(value, law)| (Some(value), law));
        let from = "/state: (E - E0)/|E0|, last frame";
        found.push(
            Measurement::new("energy.drift_relative", "1", drift, from).against(theory, source),
        );
        if let Some(orbit) = orbit.filter(|_| last.energy < 0.0 && last.time_days > 0.0) {
            let ratio = first.energy / last.energy;
            let revolutions = last.time_days / orbit.period_days();
            let rate = (ratio * ratio * ratio - 1.0) / (3.0 * revolutions);
            let from = "/state: ((E0/E)^3 - 1)/3 a period of the start: the rate at the start";
            found.push(Measurement::new("energy.drift_per_revolution", "1", rate, from).against(
                euler.then(|| law::euler_energy_drift_per_revolution(step, orbit)),
                law::EULER_ENERGY_PER_REVOLUTION,
            ));
        }
        let largest = self
            .stations
            .iter()
            .map(|station| relative_change(station.energy, first.energy).abs())
            .fold(0.0, largest_or_nan);
        let from = "/state: largest |E - E0|/|E0| of the frames";
        found.push(
            Measurement::new("energy.largest_error_relative", "1", largest, from)
                .against(self.symplectic_energy_error(), law::SYMPLECTIC_ENERGY),
        );
    }

    /// The first term of the energy error of the two lowest symplectic methods, over a revolution or more.
    fn symplectic_energy_error(&self) -> Option<f64> {
        let orbit = self.exact?;
        let covered = self.stations.last()?.time_days >= orbit.period_days();
        let step = self.config.time_step_days.get() * orbit.mean_motion_rad_per_day;
        match self.config.integrator {
            OrbitIntegrator::SemiImplicitEuler if covered => {
                let sine = orbit.sine_of_anomaly_at_start().abs();
                Some(step * orbit.eccentricity() * (1.0 + sine))
            }
            OrbitIntegrator::VelocityVerlet if covered => Some(step * step * orbit.eccentricity()),
            _ => None,
        }
    }

    fn angular_momentum_measurement(&self, first: &Station, last: &Station) -> Measurement {
        let drift = relative_change(norm(last.angular_momentum), norm(first.angular_momentum));
        let step = self.config.time_step_days.get();
        let found = Measurement::new(
            "angular_momentum.drift_relative",
            "1",
            drift,
            "/state: (L - L0)/L0, last frame",
        );
        match (self.config.integrator, &self.exact) {
            (OrbitIntegrator::ExplicitEuler, Some(orbit)) => found.against(
                law::euler_angular_momentum_drift(step, orbit, last.time_days),
                law::EULER_ANGULAR_MOMENTUM,
            ),
            (OrbitIntegrator::ExplicitEuler | OrbitIntegrator::Rk4, _) => found,
            _ => found.against(0.0, law::ANGULAR_MOMENTUM),
        }
    }
}

impl OrbitRun {
    /// The period by the clock, and Kepler's third law by it and by the width of the path; none before a revolution is done.
    fn third_law(&self, least_radius: f64, greatest_radius: f64) -> Vec<Measurement> {
        let Some(period) = self.period_days() else { return Vec::new() };
        let axis = (least_radius + greatest_radius) / 2.0;
        let ratio = TAU * TAU * axis * axis * axis / (GM_SUN_AU3_PER_DAY2 * period * period);
        let exact = self.exact.as_ref().map(KeplerOrbit::period_days);
        let from =
            "/state: time between passes of the direction of the start, mean over the revolutions";
        let about =
            "/state: 4 pi^2 a^3/(GM P^2) with a half the sum of the least and the largest |r|";
        vec![
            Measurement::new("period.measured", "d", period, from)
                .against(exact, law::KEPLERS_THIRD),
            Measurement::new("third_law.ratio", "1", ratio, about).against(1.0, law::KEPLERS_THIRD),
        ]
    }

    /// Mean time of a revolution. A pass lies on the line between two frames; it is good to the third power of their
    /// distance, since the force across the direction of the start is zero there.
    fn period_days(&self) -> Option<f64> {
        let across = |station: &Station| dot(station.position_au, self.plane[1]);
        let passes = self.stations.windows(2).skip(1).filter_map(|pair| {
            let (before, after) = (across(&pair[0]), across(&pair[1]));
            let ahead = dot(pair[1].position_au, self.plane[0]) > 0.0;
            (before < 0.0 && after >= 0.0 && ahead).then(|| {
                let share = before / (before - after);
                pair[0].time_days + share * (pair[1].time_days - pair[0].time_days)
            })
        });
        let start = self.stations.first()?.time_days;
        let (revolutions, last) = passes.fold((0.0, start), |(count, _), time| (count + 1.0, time));
        (revolutions > 0.0).then(|| (last - start) / revolutions)
    }
}

impl Observer for OrbitRun {
    fn see(&mut self, frame: &RecordedFrame) -> Result<(), ReadError> {
        if let Some(elements) = frame.get::<OrbitElements>()? {
            self.force_evaluations = Some(elements.force_evaluations);
        }
        if let Some((position, velocity)) = frame.state().and_then(|state| body(state, 0)) {
            if self.stations.is_empty() {
                self.begin(position, velocity);
            }
            let station = self.station(frame.clock.time, position, velocity);
            self.stations.push(station);
        }
        Ok(())
    }

    fn measurements(&self) -> Vec<Measurement> {
        let (Some(first), Some(last)) = (self.stations.first(), self.stations.last()) else {
            return Vec::new();
        };
        let mut found = Vec::new();
        self.energy_measurements(first, last, &mut found);
        found.push(self.angular_momentum_measurement(first, last));
        let radii = || self.stations.iter().map(|station| norm(station.position_au));
        let least = radii().fold(f64::INFINITY, |a, b| -largest_or_nan(-a, -b));
        let greatest = radii().fold(0.0, largest_or_nan);
        found.push(Measurement::new("radius.min", "AU", least, "/state: least |r| of the frames"));
        found.push(Measurement::new(
            "radius.max",
            "AU",
            greatest,
            "/state: largest |r| of the frames",
        ));
        let exact = self.config.integrator == OrbitIntegrator::Kepler;
        let theory = exact.then_some(0.0);
        if self.exact.is_some() {
            let from =
                "/state against the exact Kepler solution through the first frame, last frame";
            found.push(
                Measurement::new("position_error.final", "AU", last.position_error_au, from)
                    .against(theory, law::CONVERGENCE),
            );
            let from = "/state: angle minus that of the exact solution, last frame";
            found.push(
                Measurement::new("phase_error.final", "rad", last.phase_error_rad, from)
                    .against(theory, law::CONVERGENCE),
            );
        }
        let change = norm(std::array::from_fn(|axis| {
            last.eccentricity_vector[axis] - first.eccentricity_vector[axis]
        }));
        let from = "/state: |v x L/GM - r/|r||, change from the first frame to the last";
        found.push(Measurement::new("eccentricity_vector.change", "1", change, from));
        found.extend(self.third_law(least, greatest));
        let from = "/orbit: force evaluations, last frame";
        found.extend(
            self.force_evaluations
                .map(|count| Measurement::new("force_evaluations", "1", count as f64, from)),
        );
        found
    }

    fn figures(&self) -> Figures {
        figures::orbit::figures(self)
    }
}

/// Position and velocity of a particle.
pub(super) fn body(state: &StateTable, row: usize) -> Option<([f64; 3], [f64; 3])> {
    let value = |name: &str| state.value(row, name);
    let position = [value("x")?, value("y")?, value("z")?];
    let velocity = [value("vx")?, value("vy")?, value("vz")?];
    Some((position, velocity))
}
