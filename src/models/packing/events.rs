//! What may happen to a disc next, and which of two events comes first.

use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// A side of a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Side {
    /// Towards smaller x.
    Left,
    /// Towards larger x.
    Right,
    /// Towards smaller y.
    Bottom,
    /// Towards larger y.
    Top,
}

impl Side {
    /// The coordinate that the side lies across: 0 for x, 1 for y.
    pub(super) fn axis(self) -> usize {
        match self {
            Self::Left | Self::Right => 0,
            Self::Bottom | Self::Top => 1,
        }
    }

    /// The side that motion along an axis leads to; `None` at rest.
    pub(super) fn ahead(axis: usize, speed: f64) -> Option<Self> {
        let [low, high] = [[Self::Left, Self::Right], [Self::Bottom, Self::Top]][axis];
        if speed > 0.0 {
            Some(high)
        } else if speed < 0.0 {
            Some(low)
        } else {
            None
        }
    }

    /// Whether the side has the larger coordinate.
    pub(super) fn is_upper(self) -> bool {
        matches!(self, Self::Right | Self::Top)
    }
}

/// What happens to a disc.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum EventKind {
    /// It touches another disc.
    Pair {
        /// The other disc.
        partner: u32,
        /// The partner's number of collisions when this was predicted: if it has changed, the event is void.
        partner_collisions: u32,
    },
    /// It touches a wall of the box.
    Wall(Side),
    /// Its centre leaves its cell: bookkeeping, no event of physics.
    Crossing(Side),
    /// Nothing, ever: the disc is at rest and nobody nearby comes towards it.
    Nothing,
}

/// The soonest event of one disc.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Event {
    /// When, on the engine's clock. The largest finite number stands for never, so that every state can be stored.
    pub(super) time: f64,
    /// What.
    pub(super) kind: EventKind,
}

/// The time of an event that never comes.
pub(super) const NEVER: f64 = f64::MAX;

impl Event {
    /// The event of a disc to which nothing happens.
    pub(super) const NOTHING: Self = Self { time: NEVER, kind: EventKind::Nothing };

    /// The total order of events of one disc: by time, then by kind, then by partner or side.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        self.time.total_cmp(&other.time).then_with(|| self.kind.rank().cmp(&other.kind.rank()))
    }
}

impl EventKind {
    fn rank(self) -> (u8, u32) {
        match self {
            Self::Pair { partner, .. } => (0, partner),
            Self::Wall(side) => (1, side as u32),
            Self::Crossing(side) => (2, side as u32),
            Self::Nothing => (3, 0),
        }
    }
}
