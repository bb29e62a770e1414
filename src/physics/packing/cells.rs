//! The size of the cells, and an order of the discs by cell.

use super::domain::Domain;
use crate::cell_grid::{Cell, CellGrid};

/// Cells are wider than the largest contact distance by this factor, so that the rounding of edges and crossing times hides
/// no partner. Narrow cells leave the fewest discs to scan; at most four equal discs fit into one.
const MARGIN: f64 = 1.01;

/// Largest number of cells per disc or obstacle: in dilute systems, narrower cells would only cause more crossings. With one cell per
/// disc, cells of five discs would be frequent.
const MAX_CELLS_PER_DISC: f64 = 2.0;

/// Smallest number of columns and rows of a periodic box: with fewer, a block contains a cell twice, and two cells do not
/// determine which image of a disc is touched. A box of `PERIODIC_DIAMETERS` has room for them.
const MIN_PERIODIC_CELLS: u32 = 3;

impl Domain {
    /// Divides the box into cells wider than the largest contact distance. Until one of two discs leaves its cell, all discs
    /// that can touch a disc are in the 3 x 3 block around its cell, in a periodic box each one once.
    pub(super) fn cell_grid(&self, discs: usize) -> CellGrid {
        let area = self.sides[0] * self.sides[1];
        let all = (discs + self.obstacles.centers.len()) as f64;
        let spread = (area / (MAX_CELLS_PER_DISC * all)).sqrt();
        let narrowest = MARGIN * (2.0 * self.max_radius);
        let width = if spread > narrowest { spread } else { narrowest };
        let least = if self.has_walls { 1 } else { MIN_PERIODIC_CELLS };
        let counts = self.sides.map(|side| ((side / width) as u32).max(least));
        CellGrid::new(self.sides.map(|side| -(0.5 * side)), self.sides, counts, !self.has_walls)
    }
}

/// The sort key of a cell, by patches of 16 x 16 cells and by rows within a patch: discs sorted by it are close in memory if
/// they are close in space.
pub(super) fn patch_order([column, row]: Cell) -> u64 {
    let [column, row] = [u64::from(column), u64::from(row)];
    (row >> 4) << 36 | (column >> 4) << 8 | (row & 15) << 4 | column & 15
}
