//! Clock of a propagator: continuous time, or steps of one length.

use crate::model::{Extent, SimulationFault, Target};
use kinetoscope_manifest::quantity::Positive;
use serde::{Deserialize, Serialize};

/// A duration of N steps is recognized if rounding has made it shorter by less than this fraction of a step: N = floor(T/dt + 1e-9).
pub(super) const STEP_ROUNDING: f64 = 1e-9;

/// Clock of a propagator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Clock {
    /// Time since the start and duration of the run, s.
    Continuous { time_s: f64, duration_s: f64 },
    /// Steps of one length.
    Steps(StepClock),
}

impl Clock {
    /// Length of the run.
    pub(super) fn extent(&self) -> Extent {
        match self {
            Self::Continuous { duration_s, .. } => Extent::Time(*duration_s),
            Self::Steps(clock) => Extent::Steps { total: clock.total, step: clock.time_step_s },
        }
    }

    /// Current time, s.
    pub(super) fn time_s(&self) -> f64 {
        match self {
            Self::Continuous { time_s, .. } => *time_s,
            Self::Steps(clock) => clock.time_s(),
        }
    }

    /// Time of a target, s.
    ///
    /// # Errors
    /// A target before the current time, or a step of a clock without steps.
    pub(super) fn time_of(&self, target: Target) -> Result<f64, SimulationFault> {
        let (time_s, is_past) = match (self, target) {
            (Self::Continuous { time_s, .. }, Target::Time(target_s)) => {
                (target_s, target_s < *time_s)
            }
            (Self::Continuous { .. }, Target::Count(_)) => {
                return Err(SimulationFault::of_caller(
                    "exact propagation has no steps: frames must be requested by time".to_owned(),
                ));
            }
            (Self::Steps(clock), target) => {
                let step = clock.step_of(target);
                (step as f64 * clock.time_step_s, step < clock.done)
            }
        };
        if is_past {
            return Err(SimulationFault::of_caller(format!(
                "frames must be requested in order of time: expected a time from {} s, found {time_s} s",
                self.time_s()
            )));
        }
        Ok(time_s)
    }
}

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

    /// Time after the steps done, s: a product, never a sum.
    pub(super) fn time_s(&self) -> f64 {
        self.done as f64 * self.time_step_s
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
