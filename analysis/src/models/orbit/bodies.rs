//! Observer of several bodies that attract each other: energy, angular momentum and distance of return, all from
//! `/state`.

use super::laws::{self as law, cross, difference, dot, norm};
use super::metrics as metric;
use super::rotating_frame::{Instant, RotatingFrame};
use crate::metric::Measurements;
use crate::models::contract::Observer;
use crate::models::lyapunov::Growth;
use crate::models::series::Series;
use crate::models::{max_or_nan, relative_change};
use kinetoscope_manifest::model::{IntegratorSteps, OrbitConfig};
use kinetoscope_recording::channels::{OrbitClosestApproach, OrbitConserved};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};

/// State of all bodies; sums are divided by the total mass.
#[derive(Clone, Debug, Default)]
pub(super) struct SystemState {
    pub(super) time_days: f64,
    /// AU.
    pub(super) positions: Vec<[f64; 3]>,
    /// AU^2/day^2.
    pub(super) energy: f64,
    /// AU^2/day.
    angular_momentum: [f64; 3],
    /// sum m |r| |v|, AU^2/day.
    angular_scale: f64,
}

/// Observer of one run with several bodies.
#[derive(Clone, Debug, Default)]
pub(super) struct BodiesRun {
    /// G m of each body, AU^3/day^2.
    gravitational_parameters: Vec<f64>,
    pub(super) instants: Series<SystemState>,
    max_energy_error: f64,
    /// Maximum |L - L0| / sum of m |r| |v| at the start.
    max_angular_momentum_change: f64,
    force_evaluations: Option<u64>,
    divergence: Growth,
    duration: f64,
    pub(super) closest: Option<OrbitClosestApproach>,
    pub(super) rotating_frame: Option<RotatingFrame>,
    /// Days; `None` if the integrator chooses its steps.
    time_step: Option<f64>,
}

impl BodiesRun {
    pub(super) fn new(config: &OrbitConfig) -> Self {
        let bodies = config.bodies.iter().flatten();
        let gravitational_parameters: Vec<f64> =
            bodies.map(|body| body.gm_au3_per_day2.get()).collect();
        let has_fixed_steps = config.integrator.properties().steps != IntegratorSteps::Adaptive;
        Self {
            gravitational_parameters,
            duration: config.duration_days.get(),
            time_step: has_fixed_steps.then(|| config.time_step_days.get()),
            ..Self::default()
        }
    }

    fn rotating_frame(&self, state: &StateTable) -> Option<RotatingFrame> {
        let rows =
            (0..self.gravitational_parameters.len()).map(|row| super::observe::body(state, row));
        let (positions, velocities) = rows.collect::<Option<Vec<_>>>()?.into_iter().unzip();
        RotatingFrame::of(&self.gravitational_parameters, &Instant { positions, velocities })
    }

    fn measure_closest_approach(&self, found: &mut Measurements) {
        let Some(closest) = &self.closest else { return };
        let separation = closest.separation_au;
        found.add(metric::CLOSEST_APPROACH, separation);
        found.add(metric::CLOSEST_APPROACH_TIME, closest.time_d);
        let ratio = closest.min_separation_over_hill_radius;
        found.add(metric::CLOSEST_APPROACH_HILL_RADII, Some(ratio).filter(|ratio| !ratio.is_nan()));
        let steps = |step: f64| separation / (closest.relative_speed_au_per_day * step);
        found.add(metric::CLOSEST_APPROACH_TIME_STEPS, self.time_step.map(steps));
    }

    fn instant(&self, time_days: f64, state: &StateTable) -> Option<SystemState> {
        let total: f64 = self.gravitational_parameters.iter().sum();
        let mut instant = SystemState { time_days, ..SystemState::default() };
        for (row, parameter) in self.gravitational_parameters.iter().enumerate() {
            let (position, velocity) = super::observe::body(state, row)?;
            let fraction = parameter / total;
            instant.energy += 0.5 * fraction * dot(velocity, velocity);
            for (other, earlier) in self.gravitational_parameters.iter().zip(&instant.positions) {
                instant.energy -= fraction * other / norm(difference(position, *earlier));
            }
            let momentum = cross(position, velocity);
            for (sum, component) in instant.angular_momentum.iter_mut().zip(momentum) {
                *sum += fraction * component;
            }
            instant.angular_scale += fraction * norm(position) * norm(velocity);
            instant.positions.push(position);
        }
        Some(instant)
    }

    fn compare_with_the_start(&mut self, instant: &SystemState) {
        let Some(first) = self.instants.first() else { return };
        let error = relative_change(instant.energy, first.energy).abs();
        self.max_energy_error = max_or_nan(self.max_energy_error, error);
        let change = norm(difference(instant.angular_momentum, first.angular_momentum));
        self.max_angular_momentum_change =
            max_or_nan(self.max_angular_momentum_change, change / first.angular_scale);
    }
}

impl Observer for BodiesRun {
    fn observe(&mut self, frame: RecordedFrame) -> Result<(), ReadError> {
        self.divergence.add_frame(&frame, self.duration)?;
        if let Some(conserved) = frame.get::<OrbitConserved>()? {
            self.force_evaluations = Some(conserved.force_evaluations);
        }
        if let Some(closest) = frame.get::<OrbitClosestApproach>()? {
            self.closest = Some(closest);
        }
        if let Some(state) = frame.state()
            && self.instants.is_empty()
        {
            self.rotating_frame = self.rotating_frame(state);
        }
        if let Some(instant) = frame.state().and_then(|state| self.instant(frame.clock.time, state))
        {
            self.compare_with_the_start(&instant);
            self.instants.add(instant);
        }
        Ok(())
    }

    fn measure(&self, found: &mut Measurements) {
        let (Some(first), Some(last)) = (self.instants.first(), self.instants.last()) else {
            return;
        };
        let drift = relative_change(last.energy, first.energy);
        let pairs = first.positions.iter().zip(&last.positions);
        let distances = pairs.map(|(start, end)| norm(difference(*end, *start)));
        found.compare_with(metric::ENERGY_DRIFT, drift, law::ENERGY, 0.0);
        found.add(metric::MAX_ENERGY_ERROR, self.max_energy_error);
        found.compare(metric::ANGULAR_MOMENTUM_CHANGE, self.max_angular_momentum_change, 0.0);
        found.add(metric::RETURN_DISTANCE, distances.fold(0.0, max_or_nan));
        self.measure_closest_approach(found);
        let definitions = [metric::LYAPUNOV, metric::DIVERGENCE_TIME];
        Growth::measure(self.divergence.exponent(), definitions, None, found);
        found.add(metric::FORCE_EVALUATIONS, self.force_evaluations.map(|count| count as f64));
    }
}
