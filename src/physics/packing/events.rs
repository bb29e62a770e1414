//! What may happen to a disc next, and which of two events comes first.

use serde::{Deserialize, Serialize};

/// A side of a rectangle. Numbered so that what is asked of it is arithmetic: its direction can't be guessed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum Side {
    /// Toward smaller x.
    Left,
    /// Toward larger x.
    Right,
    /// Toward smaller y.
    Bottom,
    /// Toward larger y.
    Top,
}

impl Side {
    const ALL: [Self; 4] = [Self::Left, Self::Right, Self::Bottom, Self::Top];

    /// The coordinate that the side lies across: 0 for x, 1 for y.
    pub(super) fn axis(self) -> usize {
        self as usize >> 1
    }

    /// The side across an axis with the larger or the smaller coordinate.
    pub(super) fn across(axis: usize, is_upper: bool) -> Self {
        Self::ALL[2 * (axis & 1) + usize::from(is_upper)]
    }

    /// Whether the side has the larger coordinate.
    pub(super) fn is_upper(self) -> bool {
        self as usize & 1 == 1
    }
}

/// What happens to a disc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EventKind {
    /// It touches another disc.
    Pair(u32),
    /// It touches a wall of the box.
    Wall(Side),
    /// Its center leaves its cell: bookkeeping, no event of physics.
    Crossing(Side),
    /// Nothing, ever: the disc is at rest and nobody nearby comes toward it.
    Nothing,
}

/// The kind of an event in one word: the partner's number, or one of the last words. Their order is the order of kinds
/// (pair, wall, crossing, nothing) and within them of partners and sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct EventCode(u32);

/// The first of the words that name no partner.
const WALLS: u32 = u32::MAX - 8;
const CROSSINGS: u32 = WALLS + 4;

impl EventCode {
    /// Nothing happens.
    pub(super) const NOTHING: Self = Self(u32::MAX);

    /// A collision with this disc.
    pub(super) fn pair(partner: u32) -> Self {
        Self(partner)
    }

    /// A collision with this wall.
    pub(super) fn wall(side: Side) -> Self {
        Self(WALLS + side as u32)
    }

    /// A crossing of the upper or lower side of the cell across an axis.
    #[inline(always)]
    pub(super) fn crossing(axis: usize, is_upper: bool) -> Self {
        Self(CROSSINGS + 2 * (axis & 1) as u32 + u32::from(is_upper))
    }

    /// The kind of a word.
    #[inline(always)]
    pub(super) fn of_word(word: u32) -> Self {
        Self(word)
    }

    /// The word itself.
    pub(super) fn word(self) -> u32 {
        self.0
    }

    /// The kind again.
    pub(super) fn kind(self) -> EventKind {
        if self.0 < WALLS {
            EventKind::Pair(self.0)
        } else if self.0 < CROSSINGS {
            EventKind::Wall(Side::ALL[(self.0 - WALLS) as usize])
        } else if self == Self::NOTHING {
            EventKind::Nothing
        } else {
            EventKind::Crossing(Side::ALL[(self.0 - CROSSINGS) as usize])
        }
    }
}

/// The time of an event that never comes. The largest finite number: a calculation with it is no NaN.
pub(super) const NEVER: f64 = f64::MAX;

#[cfg(test)]
mod tests {
    use super::*;

    /// Promise: a word stands for its kind, and words are in the order pair, wall, crossing, nothing.
    #[test]
    fn words_stand_for_kinds_in_their_order() {
        let mut words = vec![EventCode::pair(0), EventCode::pair(WALLS - 1)];
        words.extend(Side::ALL.map(EventCode::wall));
        words.extend(Side::ALL.map(|side| EventCode::crossing(side.axis(), side.is_upper())));
        words.push(EventCode::NOTHING);
        assert!(words.is_sorted_by(|one, other| one < other));
        assert_eq!(words[1].kind(), EventKind::Pair(WALLS - 1));
        for (place, side) in Side::ALL.into_iter().enumerate() {
            assert_eq!(words[2 + place].kind(), EventKind::Wall(side));
            assert_eq!(words[6 + place].kind(), EventKind::Crossing(side));
            assert_eq!(Side::across(side.axis(), side.is_upper()), side);
        }
        assert_eq!(EventCode::NOTHING.kind(), EventKind::Nothing);
    }
}
