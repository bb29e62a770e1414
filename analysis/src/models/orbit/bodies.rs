//! Observer of several bodies that attract each other: energy, angular momentum and distance of return, all from
//! `/state`.

use super::laws::{self as law, cross, dot, norm};
use super::metrics as metric;
use crate::metric::Measurement;
use crate::models::contract::Observer;
use crate::models::max_or_nan;
use crate::models::relative_change;
use crate::models::series::Series;
use kinetoscope_manifest::model::OrbitConfig;
use kinetoscope_recording::channels::OrbitConserved;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};

/// State of all bodies; sums are divided by the total mass.
#[derive(Clone, Debug)]
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
#[derive(Clone, Debug)]
pub(super) struct BodiesRun {
    /// G m of each body, AU^3/day^2.
    gravitational_parameters: Vec<f64>,
    pub(super) instants: Series<SystemState>,
    max_energy_error: f64,
    /// Maximum |L - L0| / sum of m |r| |v| at the start.
    max_turn: f64,
    force_evaluations: Option<u64>,
}

impl BodiesRun {
    pub(super) fn new(config: &OrbitConfig) -> Self {
        let bodies = config.bodies.iter().flatten();
        Self {
            gravitational_parameters: bodies.map(|body| body.gm_au3_per_day2.get()).collect(),
            instants: Series::default(),
            max_energy_error: 0.0,
            max_turn: 0.0,
            force_evaluations: None,
        }
    }

    fn instant(&self, time_days: f64, state: &StateTable) -> Option<SystemState> {
        let total: f64 = self.gravitational_parameters.iter().sum();
        let mut instant = SystemState {
            time_days,
            positions: Vec::new(),
            energy: 0.0,
            angular_momentum: [0.0; 3],
            angular_scale: 0.0,
        };
        for (row, parameter) in self.gravitational_parameters.iter().enumerate() {
            let (position, velocity) = super::observe::body(state, row)?;
            let share = parameter / total;
            instant.energy += 0.5 * share * dot(velocity, velocity);
            for (other, earlier) in self.gravitational_parameters.iter().zip(&instant.positions) {
                let apart: [f64; 3] = std::array::from_fn(|axis| position[axis] - earlier[axis]);
                instant.energy -= share * other / norm(apart);
            }
            let momentum = cross(position, velocity);
            for (sum, component) in instant.angular_momentum.iter_mut().zip(momentum) {
                *sum += share * component;
            }
            instant.angular_scale += share * norm(position) * norm(velocity);
            instant.positions.push(position);
        }
        Some(instant)
    }

    fn compare_with_the_start(&mut self, instant: &SystemState) {
        let Some(first) = self.instants.first() else { return };
        let error = relative_change(instant.energy, first.energy).abs();
        self.max_energy_error = max_or_nan(self.max_energy_error, error);
        let change = std::array::from_fn(|axis| {
            instant.angular_momentum[axis] - first.angular_momentum[axis]
        });
        self.max_turn = max_or_nan(self.max_turn, norm(change) / first.angular_scale);
    }
}

impl Observer for BodiesRun {
    fn observe(&mut self, frame: RecordedFrame) -> Result<(), ReadError> {
        if let Some(conserved) = frame.get::<OrbitConserved>()? {
            self.force_evaluations = Some(conserved.force_evaluations);
        }
        if let Some(instant) = frame.state().and_then(|state| self.instant(frame.clock.time, state))
        {
            self.compare_with_the_start(&instant);
            self.instants.add(instant);
        }
        Ok(())
    }

    fn measurements(&self) -> Vec<Measurement> {
        let (Some(first), Some(last)) = (self.instants.first(), self.instants.last()) else {
            return Vec::new();
        };
        let drift = relative_change(last.energy, first.energy);
        let missed = first
            .positions
            .iter()
            .zip(&last.positions)
            .map(|(start, end)| norm(std::array::from_fn(|axis| end[axis] - start[axis])));
        let mut found = vec![
            Measurement::new(metric::ENERGY_DRIFT, drift).against_law(0.0, law::ENERGY),
            Measurement::new(metric::LARGEST_ENERGY_ERROR, self.max_energy_error),
            Measurement::new(metric::ANGULAR_MOMENTUM_CHANGE, self.max_turn).against(0.0),
            Measurement::new(metric::RETURN_DISTANCE, missed.fold(0.0, max_or_nan)),
        ];
        found.extend(
            self.force_evaluations
                .map(|count| Measurement::new(metric::FORCE_EVALUATIONS, count as f64)),
        );
        found
    }
}
