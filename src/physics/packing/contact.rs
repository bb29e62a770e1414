//! The input and the result of the contact scan.

use super::disc::DiscRecord;
use super::motion::Vector;
use crate::cell_grid::{BlockOffsets, Cell};
use crate::cell_lists::CellLists;

/// The input that all scans share.
#[derive(Clone, Copy)]
pub(super) struct ScanInput<'a> {
    /// All discs.
    pub(super) discs: &'a [DiscRecord],
    /// The discs of each cell.
    pub(super) cells: &'a CellLists,
    /// The corners of the cells of a block.
    pub(super) offsets: &'a BlockOffsets,
    /// The sizes of the discs.
    pub(super) sizes: DiscSizes<'a>,
    /// Gravity, if discs fall.
    pub(super) gravity: f64,
}

/// The sizes of the discs.
#[derive(Clone, Copy)]
pub(super) enum DiscSizes<'a> {
    /// Any two discs have this contact distance.
    Equal(f64),
    /// Each disc has its own radius.
    Mixed(&'a [f64]),
    /// Each disc has its own radius, and all grow at the same relative rate.
    Growing {
        /// Full radii.
        radii: &'a [f64],
        /// Present radius over full radius.
        scale: f64,
        /// Growth of this ratio per unit of time.
        rate: f64,
    },
}

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
