//! The collisions since the last frame, each with its discs and its impulse, which are recorded on request only.
//!
//! With a frame, they give the position and the velocity of each disc at any later time: a disc flies straight between its collisions.

use super::collision::{Collision, CollisionPartner};
use super::motion::speed;
use kinetoscope_recording::channels::PackingEvents;
use serde::{Deserialize, Serialize};

/// One entry per collision, as columns of equal length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct EventRecord {
    event: Vec<u64>,
    time: Vec<f64>,
    discs: [Vec<u64>; 2],
    impulse: [Vec<f64>; 2],
    normal: [Vec<f64>; 2],
}

impl EventRecord {
    /// Whether all columns have one length.
    pub(super) fn is_valid(&self) -> bool {
        let Self { event, time, discs, impulse, normal } = self;
        let numbers = impulse.iter().chain(normal).chain([time]).map(Vec::len);
        numbers.chain(discs.iter().map(Vec::len)).all(|length| length == event.len())
    }

    /// Appends a collision.
    pub(super) fn push(&mut self, event: u64, time: f64, collision: &Collision) {
        self.event.push(event);
        self.time.push(time);
        let second = match collision.partner {
            CollisionPartner::Disc { id, .. } => id,
            CollisionPartner::Wall => collision.disc,
        };
        let [before, after] = collision.velocity_changes[0];
        let distance = speed(collision.separation);
        for (column, disc) in self.discs.iter_mut().zip([collision.disc, second]) {
            column.push(disc.into());
        }
        for axis in 0..2 {
            self.impulse[axis].push(after[axis] - before[axis]);
            self.normal[axis].push(collision.separation[axis] / distance);
        }
    }

    /// Removes all entries.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// The message of `/events`.
    pub(super) fn message(&self) -> PackingEvents {
        let Self { event, time, discs, impulse, normal } = self.clone();
        let ([first_id, second_id], [impulse_x, impulse_y]) = (discs, impulse);
        let [normal_x, normal_y] = normal;
        PackingEvents { event, time, first_id, second_id, impulse_x, impulse_y, normal_x, normal_y }
    }
}
