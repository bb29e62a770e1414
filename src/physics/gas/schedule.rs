//! Temperatures that are set while the gas flies: step (d) of the gas document, at chosen times.

use super::motion::Particle;
use super::pressure::speed_at;
use super::{Container, Gas, Propagator};
use crate::model::{Model, SimulationFault};
use crate::sum::CompensatedSum;
use kinetoscope_manifest::model::GasConfig;
use serde::{Deserialize, Serialize};

/// What is still to be set, and what setting it added.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Schedule {
    /// Times, s, and temperatures, K, in rising order.
    settings: Vec<[f64; 2]>,
    /// The next of them.
    next: usize,
    /// Energy added so far over the first mass, m^2/s^2.
    pub(super) energy: CompensatedSum,
}

impl Schedule {
    pub(super) fn of(config: &GasConfig) -> Self {
        let settings = config.temperature_schedule.iter();
        let settings = settings.map(|setting| setting.map(|number| number.get())).collect();
        Self { settings, ..Self::default() }
    }

    /// The next setting if it comes at this time or before.
    pub(super) fn due(&self, time_s: f64) -> Option<[f64; 2]> {
        self.settings.get(self.next).copied().filter(|setting| setting[0] <= time_s)
    }
}

impl Gas {
    /// Rescales all velocities to a temperature by the definition in use, and begins new paths.
    pub(super) fn set_temperature(&mut self, temperature_k: f64) -> Result<(), SimulationFault> {
        self.schedule.next += 1;
        let moments = self.moments();
        let present = moments.squared_speed(self.substance.definition).sqrt();
        let wanted =
            speed_at(temperature_k, self.substance.mass_kg, self.substance.boltzmann_j_per_k);
        if wanted > 0.0 && present == 0.0 {
            return Err(SimulationFault(format!(
                "at {} s all particles are at rest: no factor brings them to {temperature_k} K; take 0 K off the schedule",
                self.time()
            )));
        }
        let factor = if wanted > 0.0 { wanted / present } else { 0.0 };
        let added = (factor * factor - 1.0) * moments.reduced_mean_square * moments.count / 2.0;
        self.schedule.energy.add(added);
        for id in 0..self.particles.len() {
            if !self.is_inside(id) {
                continue;
            }
            let Particle { position, velocity } = self.particles.get(id);
            let velocity = velocity.map(|component| component * factor + 0.0);
            self.particles.set(id, Particle { position, velocity });
        }
        self.begin_paths();
        Ok(())
    }

    /// Begins new paths with the particles as they are.
    fn begin_paths(&mut self) {
        let time_s = self.time();
        let Container { circle, .. } = self.container;
        let circle = super::Circle { radius: circle.radius_at(time_s), ..circle };
        match &mut self.propagator {
            Propagator::Exact(clock) => {
                clock.rebegin(&self.particles, &self.substance.mass_ratios, circle, &self.wall);
            }
            Propagator::HitByHit { law, courses, .. } => {
                for (id, course) in courses.iter_mut().enumerate() {
                    if course.is_inside() {
                        course.rebegin(law, self.particles.get(id), time_s);
                    }
                }
            }
            Propagator::Colliding { discs, .. } => discs.rebegin(&self.particles),
            Propagator::Stepped { tallies, .. } => {
                for (tally, particle) in tallies.iter_mut().zip(self.particles.iter()) {
                    tally.begin(particle);
                }
            }
            Propagator::Literal { .. } => {}
        }
        self.start = self.particles.clone();
        self.start_s = time_s;
    }
}
