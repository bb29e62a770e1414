//! The collisions since the last frame, each with its discs and its impulse, which are recorded on request only.
//!
//! With a frame, they give the position and the velocity of each disc at any later time: a disc flies straight between its collisions.

use serde::{Deserialize, Serialize};

/// One entry per collision, as columns of equal length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct EventRecord {
    pub(crate) event: Vec<u64>,
    pub(crate) time: Vec<f64>,
    /// The discs that take part; for a wall, one twice.
    pub(crate) discs: [Vec<u64>; 2],
    /// On the first disc.
    pub(crate) impulse: [Vec<f64>; 2],
    /// Unit vector from the first disc to the second one, or into the wall.
    pub(crate) normal: [Vec<f64>; 2],
}

impl EventRecord {
    /// Whether all columns have one length, and each disc is one of so many.
    pub(crate) fn is_valid(&self, count: usize) -> bool {
        let Self { event, time, discs, impulse, normal } = self;
        let numbers = impulse.iter().chain(normal).chain([time]).map(Vec::len);
        numbers.chain(discs.iter().map(Vec::len)).all(|length| length == event.len())
            && discs.iter().flatten().all(|disc| *disc < count as u64)
    }

    /// Appends a collision; `separation` has the direction of the normal and any length but 0.
    pub(crate) fn push(
        &mut self,
        (event, time): (u64, f64),
        discs: [u32; 2],
        impulse: [f64; 2],
        separation: [f64; 2],
    ) {
        self.event.push(event);
        self.time.push(time);
        let [x, y] = separation;
        let distance = (x * x + y * y).sqrt();
        for index in 0..2 {
            self.discs[index].push(discs[index].into());
            self.impulse[index].push(impulse[index]);
            self.normal[index].push(separation[index] / distance);
        }
    }

    /// Removes all entries.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}
