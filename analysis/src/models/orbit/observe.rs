//! Observer of orbits: energy, angular momentum and deviation from the exact solution, all from `/state`.

use super::laws::{self as law, GM_SUN_AU3_PER_DAY2, KeplerOrbit, cross, dot, norm};
use super::metrics as metric;
use crate::metric::Law;
use crate::metric::Measurement;
use crate::models::contract::Observer;
use crate::models::max_or_nan;
use crate::models::relative_change;
use crate::models::series::Series;
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator};
use kinetoscope_recording::channels::OrbitElements;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::TAU;

/// The planet at one instant, and its deviation from the exact solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitPoint {
    /// Simulated time, days.
    pub time_days: f64,
    /// Position, AU.
    pub position_au: [f64; 3],
    /// Energy per unit mass, AU^2/day^2.
    pub energy: f64,
    /// r x v, AU^2/day.
    pub angular_momentum: [f64; 3],
    /// v x (r x v) / GM - r/|r|.
    pub eccentricity_vector: [f64; 3],
    /// Distance from the exact position, AU; NaN if the orbit is not an ellipse.
    pub position_error_au: f64,
    /// Angle in the initial orbital plane minus the exact one, continuous between frames, rad.
    pub phase_error_rad: f64,
}

/// Observer of one orbit run.
#[derive(Clone, Debug)]
pub struct OrbitRun {
    pub(crate) config: OrbitConfig,
    pub(crate) exact: Option<KeplerOrbit>,
    pub(crate) points: Series<OrbitPoint>,
    max_energy_error: f64,
    radii: Option<[f64; 2]>,
    force_evaluations: Option<u64>,
    revolutions: Revolutions,
    /// Unit vectors of the initial orbital plane: along r0, and perpendicular to it in the sense of motion.
    plane: [[f64; 3]; 2],
}

impl OrbitRun {
    /// Creates an observer without frames.
    #[must_use]
    pub fn new(config: OrbitConfig) -> Self {
        Self {
            config,
            exact: None,
            points: Series::default(),
            max_energy_error: 0.0,
            radii: None,
            force_evaluations: None,
            revolutions: Revolutions::default(),
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

    fn point(&self, time_days: f64, position: [f64; 3], velocity: [f64; 3]) -> OrbitPoint {
        let radius = norm(position);
        let angular_momentum = cross(position, velocity);
        let turned = cross(velocity, angular_momentum);
        let exact = self.exact.map(|orbit| orbit.position_au(time_days));
        let position_error_au = exact.map_or(f64::NAN, |exact| {
            norm(std::array::from_fn(|axis| position[axis] - exact[axis]))
        });
        let phase_error_rad = exact.map_or(f64::NAN, |exact| {
            let apart = self.angle(position) - self.angle(exact);
            let before = self.points.last().map_or(0.0, |point| point.phase_error_rad);
            // The error changes by less than half a revolution between two frames.
            apart + TAU * ((before - apart) / TAU).round()
        });
        OrbitPoint {
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

    fn energy_measurements(
        &self,
        first: &OrbitPoint,
        last: &OrbitPoint,
        found: &mut Vec<Measurement>,
    ) {
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
        found.push(Measurement::new(metric::ENERGY_DRIFT, drift).against_law(theory, source));
        if let Some(orbit) = orbit.filter(|_| last.energy < 0.0 && last.time_days > 0.0) {
            let ratio = first.energy / last.energy;
            let revolutions = last.time_days / orbit.period_days();
            let rate = (ratio * ratio * ratio - 1.0) / (3.0 * revolutions);
            found.push(
                Measurement::new(metric::DRIFT_PER_REVOLUTION, rate)
                    .against(euler.then(|| law::euler_energy_drift_per_revolution(step, orbit))),
            );
        }
        found.push(
            Measurement::new(metric::LARGEST_ENERGY_ERROR, self.max_energy_error)
                .against(self.symplectic_energy_error()),
        );
    }

    /// Leading term of the energy error of the two lowest-order symplectic methods, after at least one revolution.
    fn symplectic_energy_error(&self) -> Option<f64> {
        let orbit = self.exact?;
        let covered = self.points.last()?.time_days >= orbit.period_days();
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

    fn angular_momentum_measurement(&self, first: &OrbitPoint, last: &OrbitPoint) -> Measurement {
        let drift = relative_change(norm(last.angular_momentum), norm(first.angular_momentum));
        let step = self.config.time_step_days.get();
        let found = Measurement::new(metric::ANGULAR_MOMENTUM_DRIFT, drift);
        match (self.config.integrator, &self.exact) {
            (OrbitIntegrator::ExplicitEuler, Some(orbit)) => found.against_law(
                law::euler_angular_momentum_drift(step, orbit, last.time_days),
                law::EULER_ANGULAR_MOMENTUM,
            ),
            (OrbitIntegrator::ExplicitEuler | OrbitIntegrator::Rk4, _) => found,
            _ => found.against_law(0.0, law::ANGULAR_MOMENTUM),
        }
    }

    fn eccentricity_measurements(
        &self,
        first: &OrbitPoint,
        last: &OrbitPoint,
        theory: Option<f64>,
        found: &mut Vec<Measurement>,
    ) {
        let (start, end) = (first.eccentricity_vector, last.eccentricity_vector);
        let change = norm(std::array::from_fn(|axis| end[axis] - start[axis]));
        let normal = first.angular_momentum.map(|part| part / norm(first.angular_momentum));
        let turn = dot(cross(start, end), normal).atan2(dot(start, end));
        found.extend([
            Measurement::new(metric::ECCENTRICITY_CHANGE, change).against(theory),
            Measurement::new(metric::PERIHELION_TURN, turn).against(theory),
        ]);
    }
}

impl OrbitRun {
    /// The measured period, and Kepler's third law with this period and the width of the path; empty before the first
    /// revolution.
    fn third_law(&self) -> Vec<Measurement> {
        let (Some(period), Some([least, greatest])) = (self.revolutions.period_days(), self.radii)
        else {
            return Vec::new();
        };
        let axis = (least + greatest) / 2.0;
        let ratio = TAU * TAU * axis * axis * axis / (GM_SUN_AU3_PER_DAY2 * period * period);
        let exact = self.exact.as_ref().map(KeplerOrbit::period_days);
        vec![
            Measurement::new(metric::PERIOD, period).against(exact),
            Measurement::new(metric::THIRD_LAW, ratio).against(1.0),
        ]
    }
}

/// Counts passes of the initial direction. A pass is interpolated linearly between two frames. Its error is of third
/// order in their interval, because the force perpendicular to the initial direction is zero there.
#[derive(Clone, Copy, Debug, Default)]
struct Revolutions {
    count: u32,
    start_days: Option<f64>,
    last_pass_days: f64,
    /// Time and perpendicular distance in the previous frame; `None` until the body has left the initial direction.
    before: Option<(f64, f64)>,
}

impl Revolutions {
    /// Adds a frame; `along` and `across` are the components of the position in the initial orbital plane, AU.
    fn add_frame(&mut self, time_days: f64, along: f64, across: f64) {
        if self.start_days.is_none() {
            // The start itself is not a pass.
            self.start_days = Some(time_days);
            return;
        }
        if let Some((time_before, before)) = self.before
            && before < 0.0
            && across >= 0.0
            && along > 0.0
        {
            let share = before / (before - across);
            self.last_pass_days = time_before + share * (time_days - time_before);
            self.count += 1;
        }
        self.before = Some((time_days, across));
    }

    /// Mean period of the revolutions, days.
    fn period_days(&self) -> Option<f64> {
        let start = self.start_days.filter(|_| self.count > 0)?;
        Some((self.last_pass_days - start) / f64::from(self.count))
    }
}

impl Observer for OrbitRun {
    fn observe(&mut self, frame: RecordedFrame) -> Result<(), ReadError> {
        if let Some(elements) = frame.get::<OrbitElements>()? {
            self.force_evaluations = Some(elements.force_evaluations);
        }
        let Some((position, velocity)) = frame.state().and_then(|state| body(state, 0)) else {
            return Ok(());
        };
        if self.points.is_empty() {
            self.begin(position, velocity);
        }
        let point = self.point(frame.clock.time, position, velocity);
        self.points.add(point);
        let [along, across] = self.plane.map(|axis| dot(position, axis));
        self.revolutions.add_frame(frame.clock.time, along, across);
        let start = self.points.first().map_or(point.energy, |first| first.energy);
        let error = relative_change(point.energy, start).abs();
        self.max_energy_error = max_or_nan(self.max_energy_error, error);
        let radius = norm(position);
        let [least, greatest] = self.radii.unwrap_or([radius; 2]);
        self.radii = Some([-max_or_nan(-least, -radius), max_or_nan(greatest, radius)]);
        Ok(())
    }

    fn measurements(&self) -> Vec<Measurement> {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return Vec::new();
        };
        let mut found = Vec::new();
        self.energy_measurements(first, last, &mut found);
        found.push(self.angular_momentum_measurement(first, last));
        if let Some([least, greatest]) = self.radii {
            found.push(Measurement::new(metric::LEAST_RADIUS, least));
            found.push(Measurement::new(metric::LARGEST_RADIUS, greatest));
        }
        let exact = self.config.integrator == OrbitIntegrator::Kepler;
        let theory = exact.then_some(0.0);
        if self.exact.is_some() {
            found.extend([
                Measurement::new(metric::POSITION_ERROR, last.position_error_au).against(theory),
                Measurement::new(metric::PHASE_ERROR, last.phase_error_rad).against(theory),
            ]);
        }
        self.eccentricity_measurements(first, last, theory, &mut found);
        found.extend(self.third_law());
        found.extend(
            self.force_evaluations
                .map(|count| Measurement::new(metric::FORCE_EVALUATIONS, count as f64)),
        );
        found
    }
}

/// Position and velocity of one body; `None` if a column is missing.
pub(super) fn body(state: &StateTable, row: usize) -> Option<([f64; 3], [f64; 3])> {
    let value = |name: &str| state.value(row, name);
    let position = [value("x")?, value("y")?, value("z")?];
    let velocity = [value("vx")?, value("vy")?, value("vz")?];
    Some((position, velocity))
}
