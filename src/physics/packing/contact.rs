//! The input and the result of the contact scan.

use super::motion::Vector;
use crate::cell_grid::Cell;

/// A disc in flight, as it is now.
#[derive(Clone, Copy)]
pub(super) struct MovingDisc {
    pub(super) id: u32,
    pub(super) cell: Cell,
    /// Position relative to the corner of the cell.
    pub(super) position: Vector,
    pub(super) velocity: Vector,
    /// The present time, on the engine's clock.
    pub(super) now: f64,
}

/// The first contact of a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PredictedContact {
    /// Time until the contact, or [`NEVER`](super::events::NEVER).
    pub(super) time_to_contact: f64,
    /// The other disc; of several at the same time, the one with the smallest id; the disc itself if there is none.
    pub(super) partner: u32,
}
