//! The events of a disc and their order.

use crate::cell_grid::Side;
use serde::{Deserialize, Serialize};

/// The time of an event that never occurs: the largest finite number, so that calculations with it do not give NaN.
pub(super) const NEVER: f64 = f64::MAX;

/// The kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EventKind {
    /// A collision with another disc.
    Pair(u32),
    /// A collision with an obstacle, whose number is in the record of the disc.
    Obstacle,
    /// A collision with a wall of the box.
    Wall(Side),
    /// The center leaves its cell: this changes the cell lists only.
    CellCrossing(Side),
    /// No event: the disc is at rest and no disc nearby approaches it.
    None,
}

/// An event kind in one word: the partner's id, or one of the ten largest values. The order of the codes is the order of
/// simultaneous events: pair, obstacle, wall, crossing, none; and by id or side within a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct EventCode(pub(super) u32);

/// The first codes of wall collisions and of cell crossings; smaller codes are ids of partners.
const WALLS: u32 = u32::MAX - 8;
const CROSSINGS: u32 = WALLS + 4;
// A wall or a crossing has one code per side, and the last code is that of no event.
const _: () = assert!(CROSSINGS - WALLS == SIDES && EventCode::NONE.0 - CROSSINGS == SIDES);
const SIDES: u32 = Side::ALL.len() as u32;

impl EventCode {
    /// No event.
    pub(super) const NONE: Self = Self(u32::MAX);

    /// A collision with an obstacle.
    pub(super) const OBSTACLE: Self = Self(WALLS - 1);

    /// A collision with another disc.
    pub(super) fn pair(partner: u32) -> Self {
        Self(partner)
    }

    /// A collision with a wall.
    pub(super) fn wall(side: Side) -> Self {
        Self(WALLS + side as u32)
    }

    /// A crossing of the lower or upper side of the cell along an axis.
    #[inline(always)]
    pub(super) fn cell_crossing(axis: usize, is_upper: bool) -> Self {
        Self(CROSSINGS + 2 * (axis & 1) as u32 + u32::from(is_upper))
    }

    /// The kind of the event.
    pub(super) fn kind(self) -> EventKind {
        if self.0 < Self::OBSTACLE.0 {
            EventKind::Pair(self.0)
        } else if self == Self::OBSTACLE {
            EventKind::Obstacle
        } else if self.0 < CROSSINGS {
            EventKind::Wall(Side::ALL[(self.0 - WALLS) as usize])
        } else if self == Self::NONE {
            EventKind::None
        } else {
            EventKind::CellCrossing(Side::ALL[(self.0 - CROSSINGS) as usize])
        }
    }
}
