//! Interface of the schemes that move the particles. `schemes.rs` lists its implementations.

use super::state::GasState;
use super::tallies::PairTally;
use crate::model::{Extent, SetupError, SimulationFault, Target};
use crate::random::Seed;
use kinetoscope_manifest::model::GasConfig;

/// A scheme that moves the particles of a [`GasState`] and records their collisions there.
///
/// The defaults are those of an event-driven scheme of independent particles, which can stop at any time.
pub(super) trait Propagator {
    /// The scheme at time 0; `None` if the manifest requests another one.
    ///
    /// # Errors
    /// A start that the scheme cannot run.
    fn prepare(
        config: &GasConfig,
        seed: Seed,
        state: &GasState,
    ) -> Option<Result<Self, SetupError>>
    where
        Self: Sized;

    /// Length of the run.
    fn extent(&self) -> Extent;

    /// Current time, s.
    fn time_s(&self) -> f64;

    /// Steps or events since the start.
    fn count(&self, state: &GasState) -> u64 {
        state.wall.total.collisions
    }

    /// Time of a target, s.
    ///
    /// # Errors
    /// A target before the current time, or one in a unit that the scheme does not have.
    fn time_of(&self, target: Target) -> Result<f64, SimulationFault> {
        match target {
            Target::Time(time_s) if time_s >= self.time_s() => Ok(time_s),
            Target::Time(time_s) => Err(SimulationFault(format!(
                "frames must be requested in order of time: expected a time from {} s, found {time_s} s",
                self.time_s()
            ))),
            Target::Count(_) => Err(SimulationFault(
                "exact propagation has no steps: frames must be requested by time".into(),
            )),
        }
    }

    /// Moves the particles toward a target, reduces the budget by the steps or events that this took, and returns whether the
    /// target is reached. Schemes without a cost per event ignore the budget.
    fn advance(&mut self, target: Target, budget: &mut u64, state: &mut GasState) -> bool;

    /// Starts new paths with the present particles, whose velocities were changed from outside.
    fn restart_paths(&mut self, state: &GasState);

    /// Resets the sums since the last frame that the scheme keeps itself.
    fn open_window(&mut self) {}

    /// Whether a particle has not left through the opening.
    fn is_inside(&self, _id: usize) -> bool {
        true
    }

    /// Whether the scheme has lost a particle.
    fn is_lost(&self, _id: usize) -> bool {
        false
    }

    /// Whether |R v - u p| and p x v of each particle are conserved.
    fn conserves_invariants(&self) -> bool {
        true
    }

    /// Radius of the circle that contains the centers of all discs, m; `None` for points.
    fn center_limit_m(&self) -> Option<f64> {
        None
    }

    /// Collisions between discs.
    fn pair_tally(&self) -> PairTally {
        PairTally::default()
    }

    /// Length of a step, s.
    fn time_step_s(&self) -> Option<f64> {
        None
    }

    /// Describes the scheme for the log.
    fn description(&self, state: &GasState) -> String;
}
