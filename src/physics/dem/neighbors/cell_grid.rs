//! A grid of cells at least as wide as the reach: neighbors stand in the 3 x 3 block.
//!
//! Cells are numbered band by band, column by column within a band, and upwards within a column. So the discs of a block,
//! which follow each other in this order, fill a patch about as high as wide, and few of their pairs belong to two blocks.

use std::ops::Range;

/// Which directions of the box are periodic.
pub(in crate::dem) type Periodic = [bool; 2];

/// Column and row of a cell.
type Place = [usize; 2];

/// Discs sorted by cell.
pub(in crate::dem) struct Cells {
    /// Cells a meter along each axis.
    per_meter: [f64; 2],
    /// Columns and rows.
    count: [usize; 2],
    periodic: Periodic,
    /// Rows of each band, but for the last, which may have fewer.
    band: usize,
    rows: Vec<Row>,
    /// Where a cell's discs begin in the sorted order; one entry more than cells.
    starts: Vec<u32>,
    /// The cell of each disc in the sorted order.
    cells: Vec<u32>,
}

/// Discs that follow each other in one column of a band, all of whose neighbors stand in the three columns of cells around:
/// three cells of each lie side by side.
pub(in crate::dem) struct Stretch<'a> {
    /// The cell of each.
    pub(in crate::dem) cells: &'a [u32],
    starts: &'a [u32],
    /// By how much a cell's number grows from column to column.
    step: usize,
}

impl Stretch<'_> {
    /// Where the discs of a cell's own column end, one cell further up.
    #[inline]
    pub(in crate::dem) fn end_above(&self, cell: u32) -> u32 {
        self.starts[cell as usize + 2]
    }

    /// The discs of the three cells beside it in the next column.
    #[inline]
    pub(in crate::dem) fn beside(&self, cell: u32) -> Range<u32> {
        let beside = cell as usize + self.step;
        self.starts[beside - 1]..self.starts[beside + 2]
    }
}

/// A row of cells.
#[derive(Clone, Copy)]
struct Row {
    /// Number of its cell in column 0, and by how much it grows from column to column.
    first: usize,
    step: usize,
    /// Whether the rows below and above belong to the same band.
    is_inside: bool,
}

/// A run of discs in the sorted order, and by how many box lengths they are shifted to stand beside the one that looks.
#[derive(Clone, Debug)]
pub(in crate::dem) struct Run {
    pub(in crate::dem) discs: Range<usize>,
    pub(in crate::dem) shift: [i8; 2],
}

impl Cells {
    /// The grid, and the order that sorts the positions by cell; within a cell the order given is kept. `patch` is the
    /// number of discs that should fill a patch about as high as wide.
    pub(in crate::dem) fn sort(
        positions: &[[f64; 2]],
        sides: [f64; 2],
        reach: f64,
        periodic: Periodic,
        patch: usize,
    ) -> (Self, Vec<u32>) {
        // More cells than discs would only cost memory.
        let most = 2 * ((positions.len() as f64).sqrt() as usize + 1);
        let along = |axis: usize| Ord::clamp((sides[axis] / reach) as usize, 1, most);
        let count = [along(0), along(1)];
        let per_meter = [count[0] as f64 / sides[0], count[1] as f64 / sides[1]];
        let cells_of_patch = (patch * count[0] * count[1] / Ord::max(positions.len(), 1)) as f64;
        // Three rows then lie in two bands at most.
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

    /// Counts the discs of each cell, and returns their order.
    fn fill(&mut self, positions: &[[f64; 2]]) -> Vec<u32> {
        let cell_of = |&position: &[f64; 2]| self.index(self.place(position)) as u32;
        let cells: Vec<u32> = positions.iter().map(cell_of).collect();
        // A cell is counted two entries further on: once summed, the entry after its own says where its next disc goes, and
        // in the end where the cell after it begins.
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

    /// The discs from `disc` to the returned one, those of one cell and of no other block than `own`.
    pub(in crate::dem) fn end_of_cell(&self, disc: usize, own: &Range<usize>) -> usize {
        Ord::min(self.starts[self.cells[disc] as usize + 1] as usize, own.end)
    }

    /// The longest stretch that begins with a disc and whose neighbors are all among `own`, without any image; `None` where
    /// the disc's cell is not such a one.
    pub(in crate::dem) fn stretch(&self, disc: usize, own: &Range<usize>) -> Option<Stretch<'_>> {
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
        Some(Stretch { cells: &self.cells[disc..end], starts: &self.starts, step: height })
    }

    /// The cell of a point; points outside the box belong to the cells at its edge.
    #[inline]
    fn place(&self, point: [f64; 2]) -> Place {
        // A float that is negative or no number becomes 0 here.
        let along = |axis: usize| {
            Ord::min((point[axis] * self.per_meter[axis]) as u32 as usize, self.count[axis] - 1)
        };
        [along(0), along(1)]
    }

    #[inline]
    fn index(&self, [column, row]: Place) -> usize {
        self.rows[row].first + column * self.rows[row].step
    }

    /// Lists the runs of discs in the 3 x 3 block around a point's cell, column by column from the left.
    pub(in crate::dem) fn around(&self, point: [f64; 2], found: &mut Vec<Run>) {
        let middle = self.place(point);
        found.clear();
        let [column, row] = middle;
        let Row { first, step, is_inside } = self.rows[row];
        if is_inside && column > 0 && column + 1 < self.count[0] {
            // Most cells: three cells of each column lie side by side in memory.
            let own = first + column * step;
            for middle in [own - step, own, own + step] {
                self.add([middle - 1, middle + 1], [0, 0], found);
            }
        } else {
            self.around_edge(middle, found);
        }
    }

    /// Adds a run of cells, the first and the last by their numbers.
    #[inline]
    fn add(&self, [first, last]: [usize; 2], shift: [i8; 2], found: &mut Vec<Run>) {
        let discs = self.starts[first] as usize..self.starts[last + 1] as usize;
        if !discs.is_empty() {
            found.push(Run { discs, shift });
        }
    }

    /// The same for a cell at the edge of the box or of a band.
    fn around_edge(&self, [column, row]: Place, found: &mut Vec<Run>) {
        let first = row.saturating_sub(1);
        let last = Ord::min(row + 1, self.count[1] - 1);
        // Cells of a column lie side by side in memory up to the end of the band.
        let next_band = first - first % self.band + self.band;
        for step in [-1_i8, 0, 1] {
            let Some((column, column_shift)) = self.beside(0, column, step) else { continue };
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
                if let Some((beyond, shift @ (-1 | 1))) = self.beside(1, row, side) {
                    add(beyond, beyond, shift);
                }
            }
        }
    }

    /// The next cell along an axis, and the box length that lies between; `None` behind a wall.
    fn beside(&self, axis: usize, cell: usize, step: i8) -> Option<(usize, i8)> {
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
