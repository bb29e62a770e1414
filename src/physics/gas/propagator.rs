//! Interface of the schemes that move the particles. `schemes.rs` lists its implementations.

use super::clock::Clock;
use super::state::GasState;
use super::tallies::PairTally;
use crate::event_record::EventRecord;
use crate::model::Target;

/// A scheme that moves the particles of a [`GasState`] and records their collisions there.
///
/// The defaults are those of independent particles that never leave the container.
pub(super) trait Propagator {
    /// Current time and duration.
    fn clock(&self) -> Clock;

    /// Steps or events since the start.
    fn count(&self, state: &GasState) -> u64 {
        match self.clock() {
            Clock::Steps(clock) => clock.done,
            Clock::Continuous { .. } => state.wall.total.collisions,
        }
    }

    /// Whether a restored scheme fits the particles of a valid state: as many paths, finite numbers, existing indices. No particle
    /// is faster than `max_speed`, m/s.
    fn is_valid_for(&self, state: &GasState, max_speed: f64) -> bool;

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

    /// Whether a particle can end outside the wall, so that every frame counts them.
    fn can_end_outside(&self) -> bool {
        true
    }

    /// Whether the scheme has lost each particle; empty if it loses none.
    fn lost_particles(&self) -> &[bool] {
        &[]
    }

    /// Whether |R v - u p| and p x v of each particle are conserved.
    fn conserves_invariants(&self) -> bool {
        true
    }

    /// Radius of the circle that contains the centers of all discs, m; `None` for points.
    fn center_limit_m(&self) -> Option<f64> {
        None
    }

    /// Uniform gravity toward -y, m/s^2.
    fn gravity_m_per_s2(&self) -> f64 {
        0.0
    }

    /// Position of the partition relative to the center, m, closed or removed; `None` without one.
    fn partition_m(&self) -> Option<f64> {
        None
    }

    /// Whether there is a partition that has not been removed.
    fn is_partition_closed(&self) -> bool {
        false
    }

    /// Collisions between discs.
    fn pair_tally(&self) -> PairTally {
        PairTally::default()
    }

    /// The collisions since the last frame, with impulses over the first mass; `None` if they are not recorded.
    fn events(&self) -> Option<&EventRecord> {
        None
    }

    /// Describes the scheme for the log.
    fn description(&self, state: &GasState) -> String;
}
