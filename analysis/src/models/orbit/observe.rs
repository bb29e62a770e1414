//! Observer of orbits: energy, angular momentum and deviation from the exact solution, all from `/state`.

use super::laws::{
    self as law, GM_SUN_AU3_PER_DAY2, KeplerOrbit, cross, difference, dot, norm, unit,
};
use super::metrics as metric;
use crate::metric::theory::{Expected, ExpectedValue};
use crate::metric::{Measurements, Quantity};
use crate::models::contract::Observer;
use crate::models::series::Series;
use crate::models::{max_or_nan, relative_change};
use kinetoscope_manifest::model::{IntegratorSteps, OrbitConfig, OrbitIntegrator};
use kinetoscope_recording::channels::OrbitElements;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::TAU;

/// The planet at one instant, and its deviation from the exact solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OrbitPoint {
    /// Simulated time, days.
    pub(super) time_days: f64,
    /// Position, AU.
    pub(super) position_au: [f64; 3],
    /// Energy per unit mass, AU^2/day^2.
    pub(super) energy: f64,
    /// r x v, AU^2/day.
    pub(super) angular_momentum: [f64; 3],
    /// v x (r x v) / GM - r/|r|.
    pub(super) eccentricity_vector: [f64; 3],
    /// Distance from the exact position, AU; NaN if the orbit is not an ellipse.
    pub(super) position_error_au: f64,
}

/// Observer of one orbit run.
#[derive(Clone, Debug, Default)]
pub(super) struct OrbitRun {
    pub(super) config: OrbitConfig,
    pub(super) exact: Option<KeplerOrbit>,
    pub(super) points: Series<OrbitPoint>,
    max_energy_error: f64,
    frames: u64,
    /// The channel `/orbit` of the last frame.
    elements: Option<OrbitElements>,
    /// Unit vectors of the initial orbital plane: along r0, and perpendicular to it in the sense of motion.
    plane: [[f64; 3]; 2],
}

impl OrbitRun {
    /// Creates an observer without frames.
    pub(super) fn new(config: OrbitConfig) -> Self {
        Self { config, ..Self::default() }
    }

    fn is_exact(&self) -> bool {
        self.config.integrator.properties().steps == IntegratorSteps::Exact
    }

    fn begin(&mut self, position: [f64; 3], velocity: [f64; 3]) {
        self.exact = KeplerOrbit::through(position, velocity);
        let along = unit(position);
        self.plane = [along, unit(cross(cross(position, velocity), along))];
    }

    fn angle(&self, position: [f64; 3]) -> f64 {
        libm::atan2(dot(position, self.plane[1]), dot(position, self.plane[0]))
    }

    fn point(&self, time_days: f64, position: [f64; 3], velocity: [f64; 3]) -> OrbitPoint {
        let radius = norm(position);
        let angular_momentum = cross(position, velocity);
        let turned = cross(velocity, angular_momentum);
        let exact = self.exact.map(|orbit| orbit.position_au(time_days));
        let position_error_au = exact.map_or(f64::NAN, |exact| norm(difference(position, exact)));
        OrbitPoint {
            time_days,
            position_au: position,
            energy: dot(velocity, velocity) / 2.0 - GM_SUN_AU3_PER_DAY2 / radius,
            angular_momentum,
            eccentricity_vector: std::array::from_fn(|axis| {
                turned[axis] / GM_SUN_AU3_PER_DAY2 - position[axis] / radius
            }),
            position_error_au,
        }
    }

    /// Angle of the last frame minus the exact one, rad. The whole turns are those that the model counted at every step.
    fn phase_error_rad(&self, last: &OrbitPoint, tracked: &OrbitElements) -> Option<f64> {
        let exact = self.exact?.position_au(last.time_days);
        let apart = self.angle(last.position_au) - self.angle(exact);
        Some(apart + TAU * libm::round((tracked.phase_error_rad - apart) / TAU))
    }

    fn measure_energy(&self, first: &OrbitPoint, last: &OrbitPoint, found: &mut Measurements) {
        let step = self.config.time_step_days.get();
        let orbit = self.exact.as_ref();
        let euler = orbit.filter(|_| self.config.integrator == OrbitIntegrator::ExplicitEuler);
        let averaged = |value, orbit| self.averaged_over_revolutions(value, orbit, last.time_days);
        let (law, theory) = match (self.config.integrator, euler) {
            (_, Some(orbit)) => {
                let drift = law::euler_energy_drift(step, orbit, last.time_days);
                (law::EULER_ENERGY, Some(averaged(drift, orbit)))
            }
            _ => (law::ENERGY, 0.0.expected()),
        };
        let drift = relative_change(last.energy, first.energy);
        found.compare_with(metric::ENERGY_DRIFT, drift, law, theory);
        if let Some(orbit) = orbit.filter(|_| last.energy < 0.0 && last.time_days > 0.0) {
            let ratio = first.energy / last.energy;
            let revolutions = last.time_days / orbit.period_days();
            let rate = (ratio * ratio * ratio - 1.0) / (3.0 * revolutions);
            let theory = euler
                .map(|orbit| averaged(law::euler_energy_drift_per_revolution(step, orbit), orbit));
            found.compare(metric::DRIFT_PER_REVOLUTION, rate, theory);
            self.measure_axis(ratio - 1.0, euler, last.time_days, found);
        }
        let theory = self.symplectic_energy_error();
        found.compare(metric::MAX_ENERGY_ERROR, self.max_energy_error, theory);
    }

    /// Compares the growth of the semi-major axis, a/a_0 = E_0/E, with that of explicit Euler.
    fn measure_axis(
        &self,
        growth: f64,
        euler: Option<&KeplerOrbit>,
        time_days: f64,
        found: &mut Measurements,
    ) {
        let step = self.config.time_step_days.get();
        let theory = euler.map(|orbit| {
            let kept = 1.0 - law::euler_energy_drift(step, orbit, time_days);
            let value = 1.0 / kept - 1.0;
            // The accuracy of the law is that of the energy, of which the axis is the inverse.
            let accuracy = Some(law::EULER_ENERGY.relative_accuracy * value / kept);
            ExpectedValue { accuracy, ..self.averaged_over_revolutions(value, orbit, time_days) }
        });
        found.compare(metric::AXIS_GROWTH, growth, theory);
    }

    /// A value of explicit Euler's laws, which average over revolutions.
    fn averaged_over_revolutions(
        &self,
        value: f64,
        orbit: &KeplerOrbit,
        time_days: f64,
    ) -> ExpectedValue {
        let step = self.config.time_step_days.get();
        let violation = law::outside_euler_range(step, orbit, time_days);
        ExpectedValue { value, accuracy: None, violation }
    }

    /// Leading term of the energy error of the two lowest-order symplectic methods.
    fn symplectic_energy_error(&self) -> Option<ExpectedValue> {
        let orbit = self.exact?;
        let revolutions = self.points.last()?.time_days / orbit.period_days();
        let eccentricity = orbit.eccentricity();
        let step = self.config.time_step_days.get() * orbit.mean_motion_rad_per_day;
        let value = match self.config.integrator {
            OrbitIntegrator::SemiImplicitEuler => {
                step * eccentricity * (1.0 + orbit.sine_of_anomaly_at_start().abs())
            }
            OrbitIntegrator::VelocityVerlet => step * step * eccentricity,
            _ => return None,
        };
        // The next term of semi-implicit Euler, about 0.6 (ω Δt)^2, has no factor ε.
        let is_euler = self.config.integrator == OrbitIntegrator::SemiImplicitEuler;
        let largest_step = if is_euler { (value / step / 6.0).min(0.02) } else { 0.02 };
        // The maximum lies between two frames.
        let frames = self.frames as f64 / revolutions;
        let violation = (Quantity::Eccentricity.at_most(eccentricity, 0.1))
            .or_else(|| Quantity::StepAngle.at_most(step, largest_step))
            .or_else(|| Quantity::Revolutions.at_least(revolutions, 1.0))
            .or_else(|| Quantity::FramesPerRevolution.at_least(frames, MIN_FRAMES_PER_REVOLUTION));
        Some(ExpectedValue { value, accuracy: None, violation })
    }

    fn measure_angular_momentum(
        &self,
        first: &OrbitPoint,
        last: &OrbitPoint,
        found: &mut Measurements,
    ) {
        let drift = relative_change(norm(last.angular_momentum), norm(first.angular_momentum));
        let step = self.config.time_step_days.get();
        let (law, theory) = match (self.config.integrator, &self.exact) {
            (OrbitIntegrator::ExplicitEuler, Some(orbit)) => {
                let drift = law::euler_angular_momentum_drift(step, orbit, last.time_days);
                let drift = self.averaged_over_revolutions(drift, orbit, last.time_days);
                (law::EULER_ANGULAR_MOMENTUM, Some(drift))
            }
            (integrator, _) => {
                let is_constant = integrator.properties().conserves_angular_momentum;
                (law::ANGULAR_MOMENTUM, is_constant.then_some(0.0).expected())
            }
        };
        found.compare_with(metric::ANGULAR_MOMENTUM_DRIFT, drift, law, theory);
    }

    /// Measures what the model tracks at every step: extremes of the distance, phase, and period with Kepler's third law.
    fn measure_path(&self, last: &OrbitPoint, found: &mut Measurements) {
        let tracked = [
            metric::MIN_RADIUS,
            metric::MAX_RADIUS,
            metric::PHASE_ERROR,
            metric::SEMI_MAJOR_AXIS,
            metric::PERIOD,
            metric::THIRD_LAW,
        ];
        // Recordings of earlier versions have no minimum distance.
        let Some(elements) = self.elements.as_ref().filter(|found| found.min_radius_au > 0.0)
        else {
            return tracked.iter().for_each(|metric| found.explain(metric, NOT_TRACKED));
        };
        let [least, greatest] = [elements.min_radius_au, elements.max_radius_au];
        found.add(metric::MIN_RADIUS, least);
        found.add(metric::MAX_RADIUS, greatest);
        let theory = self.is_exact().then_some(0.0);
        found.compare(metric::PHASE_ERROR, self.phase_error_rad(last, elements), theory);
        let Some(orbit) = &self.exact else { return };
        if elements.completed_revolutions == 0 {
            for metric in [metric::SEMI_MAJOR_AXIS, metric::PERIOD, metric::THIRD_LAW] {
                found.explain(metric, "the run ends before the first revolution");
            }
            return;
        }
        let period = elements.last_revolution_end_days / elements.completed_revolutions as f64;
        let axis = (least + greatest) / 2.0;
        let ratio = TAU * TAU * axis * axis * axis / (GM_SUN_AU3_PER_DAY2 * period * period);
        found.add(metric::SEMI_MAJOR_AXIS, axis);
        found.compare(metric::PERIOD, period, orbit.period_days());
        found.compare(metric::THIRD_LAW, ratio, 1.0);
    }
}

/// Frames per revolution from which the largest energy error of the frames is that of the path within 2 %.
const MIN_FRAMES_PER_REVOLUTION: f64 = 20.0;

/// Why a metric of the whole path has no value.
const NOT_TRACKED: &str = "the recording has no channel orbit, or one of an earlier version, so nothing was tracked at every step";

/// Why an orbit that is not bound is not compared with the exact solution.
const A_CIRCLE: &str = "the orbit of the first frame is a circle, which has no apsis";
/// Eccentricity up to which the direction of the perihelion is not known to the accuracy of its law, 1e-7 rad.
const LARGEST_OF_A_CIRCLE: f64 = 1e-9;
const NOT_AN_ELLIPSE: &str = "the orbit of the first frame is not an ellipse, for which alone the exact solution is known here";

impl Observer for OrbitRun {
    fn observe(&mut self, frame: RecordedFrame) -> Result<(), ReadError> {
        if let Some(elements) = frame.get::<OrbitElements>()? {
            self.elements = Some(elements);
        }
        let Some((position, velocity)) = frame.state().and_then(|state| body(state, 0)) else {
            return Ok(());
        };
        if self.points.is_empty() {
            self.begin(position, velocity);
        }
        let point = self.point(frame.clock.time, position, velocity);
        self.points.add(point);
        self.frames += 1;
        let start = self.points.first().map_or(point.energy, |first| first.energy);
        let error = relative_change(point.energy, start).abs();
        self.max_energy_error = max_or_nan(self.max_energy_error, error);
        Ok(())
    }

    fn measure(&self, found: &mut Measurements) {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else { return };
        self.measure_energy(first, last, found);
        self.measure_angular_momentum(first, last, found);
        let theory = self.is_exact().then_some(0.0);
        if self.exact.is_some() {
            found.compare(metric::POSITION_ERROR, last.position_error_au, theory);
        } else {
            found.explain(metric::POSITION_ERROR, NOT_AN_ELLIPSE);
        }
        let (start, end) = (first.eccentricity_vector, last.eccentricity_vector);
        found.compare(metric::ECCENTRICITY_CHANGE, norm(difference(end, start)), theory);
        let normal = unit(first.angular_momentum);
        if norm(start) > LARGEST_OF_A_CIRCLE {
            let rotation = libm::atan2(dot(cross(start, end), normal), dot(start, end));
            found.compare(metric::APSIDAL_ROTATION, rotation, theory);
        } else {
            found.explain(metric::APSIDAL_ROTATION, A_CIRCLE);
        }
        self.measure_path(last, found);
        let evaluations = self.elements.as_ref().map(|found| found.force_evaluations as f64);
        found.add(metric::FORCE_EVALUATIONS, evaluations);
    }
}

/// Position and velocity of one body; `None` if a column is missing.
pub(super) fn body(state: &StateTable, row: usize) -> Option<([f64; 3], [f64; 3])> {
    let value = |name: &str| state.value(row, name);
    let position = [value("x")?, value("y")?, value("z")?];
    let velocity = [value("vx")?, value("vy")?, value("vz")?];
    Some((position, velocity))
}
