//! A rectangle divided into a grid of equal cells: shared by the packing, the gas and random placement.
//!
//! Invariant: if cells are wider than the distance of interest, all discs within that distance of a disc are in the 3 x 3
//! block of cells around it.

/// A vector in the plane.
type Vector = [f64; 2];

/// Column and row of a cell.
pub(crate) type Cell = [u16; 2];

/// Offsets from a cell's corner to the corners of the nine cells of the block around it, row by row. The tables have 16
/// entries so that an index masked to four bits needs no bounds check; the ones after the ninth are 0.
#[derive(Clone, Debug)]
pub(crate) struct BlockOffsets {
    /// Along x and along y.
    pub(crate) columns: [[f64; 16]; 2],
    /// The same numbers, as one vector per cell.
    pub(crate) vectors: [Vector; 16],
}

/// Largest number of columns or rows: an index and the padding fit into 16 bits.
const MAX_COUNT: u32 = u16::MAX as u32 - 1;

/// A side of a rectangle. It is numbered so that its properties are arithmetic, because a disc's direction of flight cannot
/// be predicted by the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Side {
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
    /// All sides in the order of their numbers.
    pub(crate) const ALL: [Self; 4] = [Self::Left, Self::Right, Self::Bottom, Self::Top];

    /// The axis normal to the side: 0 for x, 1 for y.
    pub(crate) fn axis(self) -> usize {
        self as usize >> 1
    }

    /// The lower or upper side along an axis.
    pub(crate) fn along(axis: usize, is_upper: bool) -> Self {
        Self::ALL[2 * (axis & 1) + usize::from(is_upper)]
    }

    /// Whether the side has the larger coordinate.
    pub(crate) fn is_upper(self) -> bool {
        self as usize & 1 == 1
    }

    /// The unit vector out of the rectangle.
    pub(crate) fn outward_normal(self) -> Vector {
        let mut normal = [0.0; 2];
        normal[self.axis()] = if self.is_upper() { 1.0 } else { -1.0 };
        normal
    }
}

/// A rectangle divided into equal cells, with walls or periodic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellGrid {
    /// Lower left corner of the rectangle.
    min: Vector,
    /// Width and height of a cell.
    pub(crate) cell_sides: Vector,
    /// Lower and upper edge of a cell along each axis, relative to its corner.
    pub(crate) edges: [[f64; 2]; 2],
    /// Columns and rows.
    counts: [u32; 2],
    /// Columns and rows of the table of cells. Within walls it has one empty column and one empty row more, so that the
    /// block around a cell is found by wrapping in both cases.
    table: [u32; 2],
}

impl CellGrid {
    /// A grid of `counts` columns and rows over a rectangle with lower left corner `min`.
    pub(crate) fn new(min: Vector, sides: Vector, counts: [u32; 2], is_periodic: bool) -> Self {
        let counts = counts.map(|count| count.clamp(1, MAX_COUNT));
        let padding = u32::from(!is_periodic);
        let cell_sides = [sides[0] / f64::from(counts[0]), sides[1] / f64::from(counts[1])];
        Self {
            min,
            cell_sides,
            edges: cell_sides.map(|side| [0.0, side]),
            counts,
            table: [counts[0] + padding, counts[1] + padding],
        }
    }

    /// Number of cells in the table.
    pub(crate) fn table_size(&self) -> usize {
        self.table[0] as usize * self.table[1] as usize
    }

    /// Whether a cell is the last one in a direction.
    #[inline(always)]
    pub(crate) fn is_at_edge(&self, cell: Cell, axis: usize, is_upper: bool) -> bool {
        let last = if is_upper { self.counts[axis] - 1 } else { 0 };
        u32::from(cell[axis]) == last
    }

    /// The coordinate of the lower or upper edge of a cell along an axis.
    pub(crate) fn edge(&self, cell: Cell, axis: usize, is_upper: bool) -> f64 {
        let line = u32::from(cell[axis]) + u32::from(is_upper);
        f64::from(line) * self.cell_sides[axis] + self.min[axis]
    }

    /// The adjacent cell on a side; beyond the edge of the rectangle, the first one at the opposite edge.
    #[inline(always)]
    pub(crate) fn neighbor(&self, cell: Cell, side: Side) -> Cell {
        let along = |axis: usize| {
            let (index, count) = (u32::from(cell[axis]), self.counts[axis]);
            let up = u32::from(side.axis() == axis && side.is_upper());
            let down = u32::from(side.axis() == axis && !side.is_upper());
            let next = index + up;
            let next = if next == count { 0 } else { next };
            let next = if next < down { count } else { next };
            (next - down) as u16
        };
        [along(0), along(1)]
    }

    /// The cell that is a number of columns and rows further; `None` beyond a wall.
    pub(crate) fn shifted(&self, cell: Cell, by: [i32; 2]) -> Option<Cell> {
        let is_periodic = self.table == self.counts;
        let along = |axis: usize| {
            let (count, index) = (self.counts[axis] as i32, i32::from(cell[axis]) + by[axis]);
            let exists = is_periodic || (0..count).contains(&index);
            exists.then(|| index.rem_euclid(count) as u16)
        };
        Some([along(0)?, along(1)?])
    }

    /// The vector from the corner of the adjacent cell on a side to the corner of a cell.
    #[inline(always)]
    pub(crate) fn offset_from_neighbor(&self, side: Side) -> Vector {
        let along = |axis: usize| {
            let back = if side.is_upper() { -self.cell_sides[axis] } else { self.cell_sides[axis] };
            if side.axis() == axis { back } else { 0.0 }
        };
        [along(0), along(1)]
    }

    /// The cell of a point; points outside of the rectangle belong to the cells at its edge.
    pub(crate) fn cell_at(&self, point: Vector) -> Cell {
        let along = |axis: usize| {
            // A negative number becomes 0.
            let index = ((point[axis] - self.min[axis]) / self.cell_sides[axis]) as u32;
            index.min(self.counts[axis] - 1) as u16
        };
        [along(0), along(1)]
    }

    /// Whether a cell exists and contains a point up to rounding; cells at the edge of the rectangle extend beyond it.
    pub(crate) fn contains(&self, cell: Cell, point: Vector) -> bool {
        /// Tolerance over the width of a cell; crossings round to far less.
        const ROUNDING: f64 = 1e-6;
        (0..2).all(|axis| {
            let (index, tolerance) = (u32::from(cell[axis]), ROUNDING * self.cell_sides[axis]);
            let is_first = index == 0 || point[axis] >= self.edge(cell, axis, false) - tolerance;
            let is_last = index + 1 == self.counts[axis]
                || point[axis] <= self.edge(cell, axis, true) + tolerance;
            index < self.counts[axis] && point[axis].is_finite() && is_first && is_last
        })
    }

    /// The cell of a point, and the position relative to the cell's corner.
    pub(crate) fn locate(&self, point: Vector) -> (Cell, Vector) {
        let cell = self.cell_at(point);
        let along = |axis: usize| {
            (point[axis] - self.min[axis]) - f64::from(cell[axis]) * self.cell_sides[axis]
        };
        (cell, [along(0), along(1)])
    }

    /// The point at a position relative to a cell's corner.
    pub(crate) fn point(&self, cell: Cell, relative: Vector) -> Vector {
        let along = |axis: usize| {
            relative[axis] + (f64::from(cell[axis]) * self.cell_sides[axis] + self.min[axis])
        };
        [along(0), along(1)]
    }

    /// The vector from the corner of a cell to the corner of the same or an adjacent cell, across the edge of the rectangle
    /// if this is shorter.
    pub(crate) fn offset_between(&self, from: Cell, to: Cell) -> Vector {
        let along = |axis: usize| {
            let (from, to) = (u32::from(from[axis]), u32::from(to[axis]));
            if from == to {
                0.0
            } else if to == from + 1 || (from + 1 == self.table[axis] && to == 0) {
                self.cell_sides[axis]
            } else {
                -self.cell_sides[axis]
            }
        };
        [along(0), along(1)]
    }

    /// The offsets of the cells of a block, row by row.
    pub(crate) fn block_offsets(&self) -> BlockOffsets {
        let steps = [-1.0, 0.0, 1.0];
        let mut offsets = BlockOffsets { columns: [[0.0; 16]; 2], vectors: [[0.0; 2]; 16] };
        for cell in 0..9 {
            let [x, y] = [cell % 3, cell / 3].map(|step: usize| steps[step]);
            let vector = [x * self.cell_sides[0], y * self.cell_sides[1]];
            offsets.vectors[cell] = vector;
            (offsets.columns[0][cell], offsets.columns[1][cell]) = (vector[0], vector[1]);
        }
        offsets
    }

    /// Index of a cell in the table.
    #[inline(always)]
    pub(crate) fn index(&self, [column, row]: Cell) -> usize {
        u32::from(row) as usize * self.table[0] as usize + usize::from(column)
    }

    /// The columns, and the indices at which the rows begin, of the 3 x 3 block around a cell.
    #[inline(always)]
    pub(crate) fn block(&self, [column, row]: Cell) -> ([usize; 3], [usize; 3]) {
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
