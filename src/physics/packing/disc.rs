//! What the engine knows of one disc.

use super::events::EventCode;
use super::motion::{self, Vector};
use serde::{Deserialize, Serialize};

/// So many discs no longer stay in the processor's caches: where they are in memory begins to matter.
pub(super) const LARGE_SYSTEM: usize = 20_000;

/// One disc as its last collision left it, and its soonest event. One cache line: whoever looks at a neighbor fetches
/// this and nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(super) struct DiscRecord {
    /// From the lower left corner of the cell.
    pub(super) position: Vector,
    /// Velocity.
    pub(super) velocity: Vector,
    /// When it stood there, on the engine's clock.
    pub(super) time: f64,
    /// When its soonest event is, on the engine's clock.
    pub(super) event_time: f64,
    /// What that is.
    pub(super) event: EventCode,
    /// For a pair: the partner's number of collisions at the time of prediction. If it has changed, the event is void.
    pub(super) partner_collisions: u32,
    /// Collisions so far, modulo 2^32.
    pub(super) collisions: u32,
    /// Column and row of its cell.
    pub(super) cell: [u16; 2],
}

/// Stands where no disc stands: no disc ever touches it, as no comparison with its numbers holds.
pub(super) static SENTINEL: DiscRecord = DiscRecord {
    position: [f64::NAN; 2],
    velocity: [0.0; 2],
    time: 0.0,
    event_time: super::events::NEVER,
    event: EventCode::NONE,
    partner_collisions: 0,
    collisions: 0,
    cell: [0; 2],
};

impl DiscRecord {
    /// Where it is at a time, from the corner of its cell.
    #[inline(always)]
    pub(super) fn position_at(&self, time: f64) -> Vector {
        motion::free_flight(self.position, self.velocity, time - self.time)
    }
}

const _: () = assert!(size_of::<DiscRecord>() == 64);
