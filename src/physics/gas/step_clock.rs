//! Clock of the propagators that take steps of one length.

use super::tallies::ParticleTally;
use crate::model::{Extent, SimulationFault, Target};
use kinetoscope_manifest::quantity::Positive;
use serde::{Deserialize, Serialize};

/// A duration of N steps is recognized if rounding has made it shorter by less than this fraction of a step: N = floor(T/dt + 1e-9).
pub(super) const STEP_ROUNDING: f64 = 1e-9;

/// Steps of one length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct StepClock {
    pub(super) time_step_s: f64,
    pub(super) total: u64,
    pub(super) done: u64,
}

impl StepClock {
    /// A clock at step 0.
    pub(super) fn new(duration_s: Positive, time_step_s: Positive) -> Self {
        let time_step_s = time_step_s.get();
        let total = (duration_s.get() / time_step_s + STEP_ROUNDING) as u64;
        Self { time_step_s, total, done: 0 }
    }

    /// Length of the run.
    pub(super) fn extent(&self) -> Extent {
        Extent::Steps { total: self.total, step: self.time_step_s }
    }

    /// Time after the steps done, s: a product, never a sum.
    pub(super) fn time_s(&self) -> f64 {
        self.done as f64 * self.time_step_s
    }

    /// Time of a target, s.
    ///
    /// # Errors
    /// A target before the steps done.
    pub(super) fn time_of(&self, target: Target) -> Result<f64, SimulationFault> {
        let step = self.step_of(target);
        if step < self.done {
            return Err(SimulationFault(format!(
                "frames must be requested in order of time: expected a step from {}, found step {step}",
                self.done
            )));
        }
        Ok(step as f64 * self.time_step_s)
    }

    /// Number of steps to take toward a target with the given budget, which is reduced by them.
    pub(super) fn steps_toward(&self, target: Target, budget: &mut u64) -> u64 {
        let missing = self.step_of(target).saturating_sub(self.done);
        let steps = if missing < *budget { missing } else { *budget };
        *budget -= steps;
        steps
    }

    /// Whether a target is reached.
    pub(super) fn has_reached(&self, target: Target) -> bool {
        self.done >= self.step_of(target)
    }

    /// Step of a target; a time between two steps belongs to the earlier one.
    fn step_of(&self, target: Target) -> u64 {
        match target {
            Target::Count(count) => count,
            Target::Time(time) => (time / self.time_step_s + STEP_ROUNDING) as u64,
        }
    }
}

/// Starts the paths of all particles; lanes after the last particle keep empty tallies.
pub(super) fn start_paths(
    tallies: &mut [ParticleTally],
    particles: impl Iterator<Item = super::motion::Particle>,
) {
    for (tally, particle) in tallies.iter_mut().zip(particles) {
        tally.start_path(particle);
    }
}
