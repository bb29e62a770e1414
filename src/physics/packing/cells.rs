//! The grid that keeps the search for partners local.

use super::events::Side;
use super::motion::Vector;
use crate::memory::with_large_pages;

/// Cells are wider than the largest contact distance by this factor: rounding of edges and crossing times hides no
/// partner. As narrow as that, four discs fit into a cell and the search looks at the fewest.
const MARGIN: f64 = 1.01;

/// So many cells a disc at most: in dilute systems narrower cells would only be crossed. CollisionPartner one cell a disc, five would
/// often stand in one.
const CELLS_PER_DISC: f64 = 2.0;

/// An empty place.
pub(super) const NO_DISC: u32 = u32::MAX;

/// A cell in which nobody stands.
const EMPTY: [u32; 4] = [NO_DISC; 4];

/// How many of a cell's places are taken.
#[inline(always)]
fn taken(slots: &[u32; 4]) -> usize {
    slots.iter().map(|&slot| usize::from(slot != NO_DISC)).sum()
}

/// How the box is divided. Cells are wider than the contact distance, so that all discs that can touch a disc of a cell
/// before one of the two leaves its own stand in the 3 x 3 block around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    /// Width and height of the box, which is centered on the origin.
    box_sides: Vector,
    /// Width and height of a cell.
    pub(super) side: Vector,
    /// Lower and upper edge of a cell along each axis, from its corner.
    pub(super) edges: [[f64; 2]; 2],
    /// Columns and rows.
    count: [u32; 2],
    /// Columns and rows of the table: within walls one more of each, which stay empty. So the neighbors of a cell are
    /// found the same way round as in a periodic box, and walls have nobody behind them.
    table: [u32; 2],
}

impl Grid {
    /// The grid of a box. `has_walls` as against periodic.
    pub(super) fn new(
        box_sides: Vector,
        largest_contact_distance: f64,
        discs: usize,
        has_walls: bool,
    ) -> Self {
        let area = box_sides[0] * box_sides[1];
        let spread = (area / (CELLS_PER_DISC * discs as f64)).sqrt();
        let narrowest = MARGIN * largest_contact_distance;
        let width = if spread > narrowest { spread } else { narrowest };
        let along =
            |axis: usize| ((box_sides[axis] / width) as u32).clamp(1, u32::from(u16::MAX) - 1);
        let count = [along(0), along(1)];
        let padding = u32::from(has_walls);
        let side = [box_sides[0] / f64::from(count[0]), box_sides[1] / f64::from(count[1])];
        Self {
            box_sides,
            side,
            edges: side.map(|side| [0.0, side]),
            count,
            table: [count[0] + padding, count[1] + padding],
        }
    }

    /// Whether the cell is the last one on that side.
    #[inline(always)]
    pub(super) fn is_last(&self, cell: [u16; 2], axis: usize, is_upper: bool) -> bool {
        let last = if is_upper { self.count[axis] - 1 } else { 0 };
        u32::from(cell[axis]) == last
    }

    /// The next cell on a side; past the end of the box the first one of the other end.
    #[inline(always)]
    pub(super) fn beyond(&self, cell: [u16; 2], side: Side) -> [u16; 2] {
        let along = |axis: usize| {
            let (index, count) = (u32::from(cell[axis]), self.count[axis]);
            let up = u32::from(side.axis() == axis && side.is_upper());
            let down = u32::from(side.axis() == axis && !side.is_upper());
            let next = index + up;
            let next = if next == count { 0 } else { next };
            let next = if next < down { count } else { next };
            (next - down) as u16
        };
        [along(0), along(1)]
    }

    /// From the corner of the next cell on a side back to the corner of a cell.
    #[inline(always)]
    pub(super) fn step_back(&self, side: Side) -> Vector {
        let along = |axis: usize| {
            let back = if side.is_upper() { -self.side[axis] } else { self.side[axis] };
            if side.axis() == axis { back } else { 0.0 }
        };
        [along(0), along(1)]
    }

    /// The cell of a point of the box, and the point from that cell's corner.
    pub(super) fn locate(&self, point: Vector) -> ([u16; 2], Vector) {
        let mut cell = [0; 2];
        let mut inside = [0.0; 2];
        for axis in 0..2 {
            let from_corner = point[axis] + 0.5 * self.box_sides[axis];
            let index = ((from_corner / self.side[axis]) as u32).min(self.count[axis] - 1);
            cell[axis] = index as u16;
            inside[axis] = from_corner - f64::from(index) * self.side[axis];
        }
        (cell, inside)
    }

    /// The point of the box that is at `inside` from a cell's corner.
    pub(super) fn place(&self, cell: [u16; 2], inside: Vector) -> Vector {
        let along = |axis: usize| {
            inside[axis] + (f64::from(cell[axis]) * self.side[axis] - 0.5 * self.box_sides[axis])
        };
        [along(0), along(1)]
    }

    /// From the corner of a cell to the corner of another one, at most one cell away, the nearest way round.
    pub(super) fn shift(&self, from: [u16; 2], to: [u16; 2]) -> Vector {
        let along = |axis: usize| {
            let (from, to) = (u32::from(from[axis]), u32::from(to[axis]));
            if from == to {
                0.0
            } else if to == from + 1 || (from + 1 == self.table[axis] && to == 0) {
                self.side[axis]
            } else {
                -self.side[axis]
            }
        };
        [along(0), along(1)]
    }

    /// The corners of the block around a cell, row by row, from that cell's own corner.
    pub(super) fn offsets(&self) -> BlockOffsets {
        let steps = [-1.0, 0.0, 1.0];
        let mut offsets = [[0.0; 16]; 2];
        for place in 0..9 {
            offsets[0][place] = steps[place % 3] * self.side[0];
            offsets[1][place] = steps[place / 3] * self.side[1];
        }
        offsets
    }

    /// The order of cells by patches of 16 x 16, row by row in each: near in this order is near in space.
    pub(super) fn order(&self, [column, row]: [u16; 2]) -> u64 {
        let [column, row] = [u64::from(column), u64::from(row)];
        (row >> 4) << 36 | (column >> 4) << 8 | (row & 15) << 4 | column & 15
    }

    #[inline(always)]
    fn index(&self, [column, row]: [u16; 2]) -> usize {
        u32::from(row) as usize * self.table[0] as usize + usize::from(column)
    }

    /// The columns and the beginnings of the rows of the 3 x 3 block around a cell.
    #[inline(always)]
    fn around(&self, [column, row]: [u16; 2]) -> ([usize; 3], [usize; 3]) {
        let ring = |index: u16, count: u32| {
            let index = u32::from(index);
            let before = if index == 0 { count - 1 } else { index - 1 };
            let after = if index + 1 == count { 0 } else { index + 1 };
            [before as usize, index as usize, after as usize]
        };
        let [below, own, above] = ring(row, self.table[1]);
        let width = self.table[0] as usize;
        (ring(column, self.table[0]), [below * width, own * width, above * width])
    }
}

/// Corners of the nine cells of a block, x and y, in a table whose size is a power of two.
pub(super) type BlockOffsets = [[f64; 16]; 2];

/// Who stands in which cell. The order of discs within a cell has no influence on any result.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    /// The division.
    pub(super) grid: Grid,
    /// Four places a cell, filled from the first. In the last one may stand the first of several.
    slots: Vec<[u32; 4]>,
    /// The disc that stands behind a disc in the last place. Empty until a cell has five discs.
    behind: Vec<u32>,
    /// How many stand behind others.
    crowd: usize,
}

impl Cells {
    /// Cells in which nobody stands.
    pub(super) fn new(grid: Grid) -> Self {
        let size = grid.table[0] as usize * grid.table[1] as usize;
        let mut slots = with_large_pages(size);
        slots.resize(size, EMPTY);
        Self { grid, slots, behind: Vec::new(), crowd: 0 }
    }

    /// Whether a cell has more discs than places.
    #[inline(always)]
    pub(super) fn has_overflow(&self) -> bool {
        self.crowd > 0
    }

    /// The four places of each cell of the block around a cell, row by row.
    #[inline(always)]
    pub(super) fn around(&self, cell: [u16; 2]) -> [&[u32; 4]; 9] {
        let (columns, rows) = self.grid.around(cell);
        let mut around = [&EMPTY; 9];
        for (place, slots) in around.iter_mut().enumerate() {
            *slots = &self.slots[rows[place / 3] + columns[place % 3]];
        }
        around
    }

    /// All places, and the beginnings of the rows and the columns of the block around a cell: the sum of one of each is the
    /// number of a cell.
    #[inline(always)]
    pub(super) fn block(&self, cell: [u16; 2]) -> (&[[u32; 4]], [usize; 3], [usize; 3]) {
        let (columns, rows) = self.grid.around(cell);
        (&self.slots, rows, columns)
    }

    /// The disc behind one in a last place, or [`NO_DISC`].
    #[inline(always)]
    pub(super) fn behind(&self, disc: u32) -> u32 {
        if self.behind.is_empty() { NO_DISC } else { self.behind[disc as usize] }
    }

    /// Puts a disc into a cell; `discs` is the number of all discs.
    #[inline(always)]
    pub(super) fn insert(&mut self, disc: u32, cell: [u16; 2], discs: usize) {
        let index = self.grid.index(cell);
        let slots = &mut self.slots[index];
        let taken = taken(slots);
        if let Some(free) = slots.get_mut(taken) {
            *free = disc;
        } else {
            self.insert_behind(disc, index, discs);
        }
    }

    #[inline(never)]
    fn insert_behind(&mut self, disc: u32, index: usize, discs: usize) {
        if self.behind.is_empty() {
            self.behind = vec![NO_DISC; discs];
        }
        let last = &mut self.slots[index][3];
        self.behind[disc as usize] = *last;
        *last = disc;
        self.crowd += 1;
    }

    /// Takes a disc out of the cell that it stands in.
    #[inline(always)]
    pub(super) fn remove(&mut self, disc: u32, cell: [u16; 2]) {
        let index = self.grid.index(cell);
        if self.has_overflow() {
            self.remove_from_crowd(disc, index);
            return;
        }
        let slots = &mut self.slots[index];
        // The disc stands in one of the four places. Written without branches: which one can't be guessed.
        let place = usize::from(slots[1] == disc)
            + 2 * usize::from(slots[2] == disc)
            + 3 * usize::from(slots[3] == disc);
        let last = (taken(slots) + 3) % 4;
        slots[place] = slots[last];
        slots[last] = NO_DISC;
    }

    #[inline(never)]
    fn remove_from_crowd(&mut self, disc: u32, index: usize) {
        let mut slots = self.slots[index];
        let last = (taken(&slots) + 3) % 4;
        match slots.iter().position(|&other| other == disc) {
            Some(place) => {
                let moved = slots[last];
                slots[last] = self.behind(moved);
                if place != last {
                    slots[place] = moved;
                }
                if slots[last] != NO_DISC {
                    self.behind[moved as usize] = NO_DISC;
                    self.crowd -= 1;
                }
            }
            None => self.unlink(disc, slots[3]),
        }
        self.slots[index] = slots;
    }

    /// Takes a disc out of the row behind `first`.
    fn unlink(&mut self, disc: u32, first: u32) {
        let mut before = first;
        while before != NO_DISC {
            let next = self.behind(before);
            if next == disc {
                self.behind[before as usize] = self.behind[disc as usize];
                self.behind[disc as usize] = NO_DISC;
                self.crowd -= 1;
                return;
            }
            before = next;
        }
    }

    /// Calls `visit` with every disc of the 3 x 3 block around a cell.
    pub(super) fn for_each_near(&self, cell: [u16; 2], mut visit: impl FnMut(u32)) {
        for slots in self.around(cell) {
            for &slot in slots {
                let mut disc = slot;
                while disc != NO_DISC {
                    visit(disc);
                    disc = self.behind(disc);
                }
            }
        }
    }
}
