//! Observer of orbits: energy, angular momentum and deviation from the exact solution, all from `/state`.

use super::laws::{
    self as law, GM_SUN_AU3_PER_DAY2, KeplerOrbit, cross, difference, dot, norm, unit,
};
use super::metrics as metric;
use crate::metric::Measurements;
use crate::models::contract::Observer;
use crate::models::series::Series;
use crate::models::{max_or_nan, relative_change};
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator};
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
    /// Angle in the initial orbital plane minus the exact one, continuous between frames, rad.
    pub(super) phase_error_rad: f64,
}

/// Observer of one orbit run.
#[derive(Clone, Debug, Default)]
pub(super) struct OrbitRun {
    pub(super) config: OrbitConfig,
    pub(super) exact: Option<KeplerOrbit>,
    pub(super) points: Series<OrbitPoint>,
    max_energy_error: f64,
    radii: Option<[f64; 2]>,
    force_evaluations: Option<u64>,
    revolutions: Revolutions,
    /// Unit vectors of the initial orbital plane: along r0, and perpendicular to it in the sense of motion.
    plane: [[f64; 3]; 2],
}

impl OrbitRun {
    /// Creates an observer without frames.
    pub(super) fn new(config: OrbitConfig) -> Self {
        Self { config, ..Self::default() }
    }

    fn begin(&mut self, position: [f64; 3], velocity: [f64; 3]) {
        self.exact = KeplerOrbit::through(position, velocity);
        let along = unit(position);
        self.plane = [along, unit(cross(cross(position, velocity), along))];
    }

    fn angle(&self, position: [f64; 3]) -> f64 {
        dot(position, self.plane[1]).atan2(dot(position, self.plane[0]))
    }

    fn point(&self, time_days: f64, position: [f64; 3], velocity: [f64; 3]) -> OrbitPoint {
        let radius = norm(position);
        let angular_momentum = cross(position, velocity);
        let turned = cross(velocity, angular_momentum);
        let exact = self.exact.map(|orbit| orbit.position_au(time_days));
        let position_error_au = exact.map_or(f64::NAN, |exact| norm(difference(position, exact)));
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

    fn measure_energy(&self, first: &OrbitPoint, last: &OrbitPoint, found: &mut Measurements) {
        let step = self.config.time_step_days.get();
        let orbit = self.exact.as_ref();
        let euler = orbit.filter(|_| self.config.integrator == OrbitIntegrator::ExplicitEuler);
        let (law, theory) = match (self.config.integrator, euler) {
            (_, Some(orbit)) => {
                let drift = law::euler_energy_drift(step, orbit, last.time_days);
                (law::EULER_ENERGY, Some(drift))
            }
            (OrbitIntegrator::Kepler, None) => (law::ENERGY, Some(0.0)),
            _ => (law::ENERGY, None),
        };
        let drift = relative_change(last.energy, first.energy);
        found.compare_with(metric::ENERGY_DRIFT, drift, law, theory);
        if let Some(orbit) = orbit.filter(|_| last.energy < 0.0 && last.time_days > 0.0) {
            let ratio = first.energy / last.energy;
            let revolutions = last.time_days / orbit.period_days();
            let rate = (ratio * ratio * ratio - 1.0) / (3.0 * revolutions);
            let theory = euler.map(|orbit| law::euler_energy_drift_per_revolution(step, orbit));
            found.compare(metric::DRIFT_PER_REVOLUTION, rate, theory);
        }
        let theory = self.symplectic_energy_error();
        found.compare(metric::MAX_ENERGY_ERROR, self.max_energy_error, theory);
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
                (law::EULER_ANGULAR_MOMENTUM, Some(drift))
            }
            (OrbitIntegrator::ExplicitEuler | OrbitIntegrator::Rk4, _) => {
                (law::ANGULAR_MOMENTUM, None)
            }
            _ => (law::ANGULAR_MOMENTUM, Some(0.0)),
        };
        found.compare_with(metric::ANGULAR_MOMENTUM_DRIFT, drift, law, theory);
    }

    /// The measured period, and Kepler's third law with this period and the width of the path; nothing before the first
    /// revolution.
    fn measure_third_law(&self, found: &mut Measurements) {
        let (Some(period), Some([least, greatest])) = (self.revolutions.period_days(), self.radii)
        else {
            return;
        };
        let axis = (least + greatest) / 2.0;
        let ratio = TAU * TAU * axis * axis * axis / (GM_SUN_AU3_PER_DAY2 * period * period);
        found.compare(metric::PERIOD, period, self.exact.as_ref().map(KeplerOrbit::period_days));
        found.compare(metric::THIRD_LAW, ratio, 1.0);
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
            let fraction = before / (before - across);
            self.last_pass_days = time_before + fraction * (time_days - time_before);
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

    fn measure(&self, found: &mut Measurements) {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else { return };
        self.measure_energy(first, last, found);
        self.measure_angular_momentum(first, last, found);
        found.add(metric::MIN_RADIUS, self.radii.map(|[least, _]| least));
        found.add(metric::MAX_RADIUS, self.radii.map(|[_, greatest]| greatest));
        let exact = self.config.integrator == OrbitIntegrator::Kepler;
        let theory = exact.then_some(0.0);
        if self.exact.is_some() {
            found.compare(metric::POSITION_ERROR, last.position_error_au, theory);
            found.compare(metric::PHASE_ERROR, last.phase_error_rad, theory);
        }
        let (start, end) = (first.eccentricity_vector, last.eccentricity_vector);
        found.compare(metric::ECCENTRICITY_CHANGE, norm(difference(end, start)), theory);
        let normal = unit(first.angular_momentum);
        let rotation = dot(cross(start, end), normal).atan2(dot(start, end));
        found.compare(metric::APSIDAL_ROTATION, rotation, theory);
        self.measure_third_law(found);
        found.add(metric::FORCE_EVALUATIONS, self.force_evaluations.map(|count| count as f64));
    }
}

/// Position and velocity of one body; `None` if a column is missing.
pub(super) fn body(state: &StateTable, row: usize) -> Option<([f64; 3], [f64; 3])> {
    let value = |name: &str| state.value(row, name);
    let position = [value("x")?, value("y")?, value("z")?];
    let velocity = [value("vx")?, value("vy")?, value("vz")?];
    Some((position, velocity))
}
