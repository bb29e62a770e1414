//! A grid of cells at least as wide as the reach: all neighbors of a disc are in the 3 x 3 cells around it.
//!
//! Cells are numbered band by band, column by column within a band, and upward within a column. Therefore, the discs of a block,
//! which are adjacent in this order, fill a patch about as high as wide, and few of their pairs belong to two blocks.

use std::ops::Range;

/// Column and row of a cell.
type Cell = [usize; 2];

/// Discs sorted by cell.
pub(crate) struct CellGrid {
    /// Cells per meter along each axis.
    per_meter: [f64; 2],
    /// Columns and rows.
    count: [usize; 2],
    periodic: [bool; 2],
    /// Rows per band; the last band may have fewer.
    band: usize,
    rows: Vec<Row>,
    /// The first disc of each cell in the sorted order, and the end of the last cell.
    starts: Vec<u32>,
    /// The cell of each disc in the sorted order.
    cells: Vec<u32>,
}

/// Adjacent discs in one column of a band, all of whose neighbors are in three columns of three adjacent cells.
pub(crate) struct ColumnRun<'a> {
    /// The cell of each disc.
    pub(crate) cells: &'a [u32],
    starts: &'a [u32],
    /// Difference of the cell numbers of adjacent columns.
    step: usize,
}

impl ColumnRun<'_> {
    /// The end of the discs in a cell and in the one above it.
    #[inline]
    pub(crate) fn end_above(&self, cell: u32) -> u32 {
        self.starts[cell as usize + 2]
    }

    /// The discs of the three adjacent cells in the next column.
    #[inline]
    pub(crate) fn next_column(&self, cell: u32) -> Range<u32> {
        let next = cell as usize + self.step;
        self.starts[next - 1]..self.starts[next + 2]
    }
}

/// A row of cells.
#[derive(Clone, Copy)]
struct Row {
    /// Number of its cell in column 0, and the difference from column to column.
    first: usize,
    step: usize,
    /// Whether the rows below and above belong to the same band.
    is_inside: bool,
}

/// A run of discs in the sorted order, and the number of box lengths by which they are shifted.
#[derive(Clone, Debug)]
pub(crate) struct CellRun {
    pub(crate) discs: Range<usize>,
    pub(crate) shift: [i8; 2],
}

impl CellGrid {
    /// The grid, and the order that sorts the positions by cell; within a cell the given order is kept. `patch` is the
    /// number of discs that should fill a patch about as high as wide.
    pub(crate) fn sort(
        positions: &[[f64; 2]],
        sides: [f64; 2],
        reach: f64,
        periodic: [bool; 2],
        patch: usize,
    ) -> (Self, Vec<u32>) {
        // More cells than discs would only take memory.
        let most = 2 * ((positions.len() as f64).sqrt() as usize + 1);
        let along = |axis: usize| Ord::clamp((sides[axis] / reach) as usize, 1, most);
        let count = [along(0), along(1)];
        let per_meter = [count[0] as f64 / sides[0], count[1] as f64 / sides[1]];
        let cells_of_patch = (patch * count[0] * count[1] / Ord::max(positions.len(), 1)) as f64;
        // Three rows are then in two bands at most.
        let band = Ord::clamp(cells_of_patch.sqrt() as usize, 2, Ord::max(2, count[1]));
        let rows = (0..count[1]).map(|row| {
            let (height, above) = (Ord::min(band, count[1] - (row - row % band)), row % band);
            let first = (row - above) * count[0] + above;
            Row { first, step: height, is_inside: above > 0 && above + 1 < height }
        });
        let rows = rows.collect();
        let (starts, cells) = (Vec::new(), Vec::new());
        let mut cells = Self { per_meter, count, periodic, band, rows, starts, cells };
        let order = cells.fill(positions);
        (cells, order)
    }

    /// Counts the discs of each cell, and returns the sorted order.
    fn fill(&mut self, positions: &[[f64; 2]]) -> Vec<u32> {
        let cell_of = |&position: &[f64; 2]| self.index(self.cell_at(position)) as u32;
        let cells: Vec<u32> = positions.iter().map(cell_of).collect();
        // A cell is counted two entries ahead: after the sum, the entry after its own is the place of its next disc, and
        // in the end the start of the next cell.
        let mut starts = vec![0_u32; self.count[0] * self.count[1] + 2];
        for &cell in &cells {
            starts[cell as usize + 2] += 1;
        }
        for cell in 2..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut order = vec![0; positions.len()];
        self.cells.resize(positions.len(), 0);
        for (disc, &cell) in (0..).zip(&cells) {
            let next = &mut starts[cell as usize + 1];
            order[*next as usize] = disc;
            self.cells[*next as usize] = cell;
            *next += 1;
        }
        starts.pop();
        self.starts = starts;
        order
    }

    /// The end of the discs from `disc` on that are in the same cell and in the block `own`.
    pub(crate) fn end_of_cell(&self, disc: usize, own: &Range<usize>) -> usize {
        Ord::min(self.starts[self.cells[disc] as usize + 1] as usize, own.end)
    }

    /// The longest run that begins with a disc and whose neighbors are all in the block `own`, without images; `None` if
    /// the disc's cell does not allow one.
    pub(crate) fn column_run(&self, disc: usize, own: &Range<usize>) -> Option<ColumnRun<'_>> {
        let cell = self.cells[disc] as usize;
        let cells_of_band = self.band * self.count[0];
        let (band, place) = (cell / cells_of_band, cell % cells_of_band);
        let height = Ord::min(self.band, self.count[1] - band * self.band);
        let (column, above) = (place / height, place % height);
        if column == 0 || column + 1 == self.count[0] || above == 0 || above + 1 == height {
            return None;
        }
        let lowest = cell - above;
        let around = self.starts[lowest - height]..self.starts[lowest + 2 * height];
        if (around.start as usize) < own.start || around.end as usize > own.end {
            return None;
        }
        let end = Ord::min(self.starts[lowest + height - 1] as usize, own.end);
        Some(ColumnRun { cells: &self.cells[disc..end], starts: &self.starts, step: height })
    }

    /// The cell of a point; points outside the box belong to the cells at its border.
    #[inline]
    fn cell_at(&self, point: [f64; 2]) -> Cell {
        // A float that is negative or not a number becomes 0 here.
        let along = |axis: usize| {
            Ord::min((point[axis] * self.per_meter[axis]) as u32 as usize, self.count[axis] - 1)
        };
        [along(0), along(1)]
    }

    #[inline]
    fn index(&self, [column, row]: Cell) -> usize {
        self.rows[row].first + column * self.rows[row].step
    }

    /// Lists the runs of discs in the 3 x 3 cells around a point, column by column from the left.
    pub(crate) fn around(&self, point: [f64; 2], found: &mut Vec<CellRun>) {
        let middle = self.cell_at(point);
        found.clear();
        let [column, row] = middle;
        let Row { first, step, is_inside } = self.rows[row];
        if is_inside && column > 0 && column + 1 < self.count[0] {
            // Most cells: three cells of each column are adjacent in memory.
            let own = first + column * step;
            for middle in [own - step, own, own + step] {
                self.add([middle - 1, middle + 1], [0, 0], found);
            }
        } else {
            self.around_border(middle, found);
        }
    }

    /// Adds a run of cells, the first and the last by their numbers.
    #[inline]
    fn add(&self, [first, last]: [usize; 2], shift: [i8; 2], found: &mut Vec<CellRun>) {
        let discs = self.starts[first] as usize..self.starts[last + 1] as usize;
        if !discs.is_empty() {
            found.push(CellRun { discs, shift });
        }
    }

    /// The same for a cell at the border of the box or of a band.
    fn around_border(&self, [column, row]: Cell, found: &mut Vec<CellRun>) {
        let first = row.saturating_sub(1);
        let last = Ord::min(row + 1, self.count[1] - 1);
        // Cells of a column are adjacent in memory up to the end of the band.
        let next_band = first - first % self.band + self.band;
        for step in [-1_i8, 0, 1] {
            let Some((column, column_shift)) = self.neighbor(0, column, step) else { continue };
            let mut add = |from: usize, to: usize, row_shift: i8| {
                let ends = [self.index([column, from]), self.index([column, to])];
                self.add(ends, [column_shift, row_shift], found);
            };
            if last < next_band {
                add(first, last, 0);
            } else {
                add(first, next_band - 1, 0);
                add(next_band, last, 0);
            }
            for side in [-1_i8, 1] {
                if let Some((beyond, shift @ (-1 | 1))) = self.neighbor(1, row, side) {
                    add(beyond, beyond, shift);
                }
            }
        }
    }

    /// The adjacent cell along an axis, and the box lengths between; `None` behind a wall.
    fn neighbor(&self, axis: usize, cell: usize, step: i8) -> Option<(usize, i8)> {
        let count = self.count[axis];
        let next = cell as i64 + i64::from(step);
        if next < 0 {
            return self.periodic[axis].then_some((count - 1, -1));
        }
        if next as usize >= count {
            return self.periodic[axis].then_some((0, 1));
        }
        Some((next as usize, 0))
    }
}
