//! The state of one disc.

use super::events::{EventCode, NEVER};
use super::motion::{self, Vector};
use crate::cell_grid::Cell;
use serde::{Deserialize, Serialize};

/// Number of discs that no longer fit into the processor's caches, so that their order in memory matters.
pub(super) const LARGE_SYSTEM: usize = 20_000;

/// A disc after its last collision, and its next event. A record is one cache line: reading a neighbor reads nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(super) struct DiscRecord {
    /// Position relative to the lower left corner of the cell.
    pub(super) position: Vector,
    /// Velocity.
    pub(super) velocity: Vector,
    /// Time of the position, on the engine's clock.
    pub(super) time: f64,
    /// Time of the next event, on the engine's clock.
    pub(super) event_time: f64,
    /// The next event.
    pub(super) event: EventCode,
    /// For a pair collision: the partner's collision count at the prediction. If the count has changed, the event is
    /// invalid. For a collision with an obstacle: its number.
    pub(super) partner_collisions: u32,
    /// Number of collisions, modulo 2^32.
    pub(super) collisions: u32,
    /// Column and row of the cell.
    pub(super) cell: Cell,
}

/// Takes the place of a disc in empty lanes. No disc touches it, because comparisons with NaN are false.
pub(super) static SENTINEL: DiscRecord = DiscRecord {
    position: [f64::NAN; 2],
    velocity: [0.0; 2],
    time: 0.0,
    event_time: NEVER,
    event: EventCode::NONE,
    partner_collisions: 0,
    collisions: 0,
    cell: [0; 2],
};

impl DiscRecord {
    /// A disc at time 0, without an event.
    pub(super) fn new(cell: Cell, position: Vector, velocity: Vector) -> Self {
        Self { position, velocity, cell, ..SENTINEL }
    }

    /// The position at a time, relative to the corner of the cell, and the velocity. `FALLS` says whether there is gravity.
    #[inline(always)]
    pub(super) fn at<const FALLS: bool>(&self, time: f64, gravity: f64) -> (Vector, Vector) {
        let age = time - self.time;
        if FALLS {
            motion::free_fall(self.position, self.velocity, gravity, age)
        } else {
            (motion::free_flight(self.position, self.velocity, age), self.velocity)
        }
    }
}

const _: () = assert!(size_of::<DiscRecord>() == 64);
