//! A grid of cells at least as wide as the reach: neighbours stand in the 3 x 3 block.
//!
//! Cells are numbered band by band, column by column within a band, and upwards within a column. So the discs of a block,
//! which follow each other in this order, fill a patch about as high as wide, and few of their pairs belong to two blocks.

use std::ops::Range;

/// Which directions of the box are periodic.
pub(super) type Periodic = [bool; 2];

/// Column and row of a cell.
type Place = [usize; 2];

/// Discs sorted by cell.
pub(super) struct Cells {
    /// Cells a metre along each axis.
    per_metre: [f64; 2],
    /// Columns and rows.
    count: [usize; 2],
    periodic: Periodic,
    /// Rows of each band, but for the last, which may have fewer.
    band: usize,
    rows: Vec<Row>,
    /// Where a cell's discs begin in the sorted order; one entry more than cells.
    starts: Vec<u32>,
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
pub(super) struct Run {
    pub(super) discs: Range<usize>,
    pub(super) shift: [i8; 2],
}

/// The runs in a 3 x 3 block of cells.
#[derive(Default)]
pub(super) struct Runs {
    pub(super) runs: Vec<Run>,
    /// The cell in the middle; `None` before the first.
    middle: Option<Place>,
}

impl Runs {
    /// Whether all discs are among these, and none is shifted.
    pub(super) fn are_within(&self, discs: &Range<usize>) -> bool {
        self.runs.iter().all(|run| {
            run.shift == [0, 0] && run.discs.start >= discs.start && run.discs.end <= discs.end
        })
    }
}

impl Cells {
    /// The grid, and the order that sorts the positions by cell; within a cell the order given is kept. `patch` is the
    /// number of discs that should fill a patch about as high as wide.
    pub(super) fn sort(
        positions: &[[f64; 4]],
        sides: [f64; 2],
        reach: f64,
        periodic: Periodic,
        patch: usize,
    ) -> (Self, Vec<u32>) {
        // More cells than discs would only cost memory.
        let most = 2 * ((positions.len() as f64).sqrt() as usize + 1);
        let along = |axis: usize| Ord::clamp((sides[axis] / reach) as usize, 1, most);
        let count = [along(0), along(1)];
        let per_metre = [count[0] as f64 / sides[0], count[1] as f64 / sides[1]];
        let cells_of_patch = (patch * count[0] * count[1] / Ord::max(positions.len(), 1)) as f64;
        // Three rows then lie in two bands at most.
        let band = Ord::clamp(cells_of_patch.sqrt() as usize, 2, Ord::max(2, count[1]));
        let rows = (0..count[1]).map(|row| {
            let (height, above) = (Ord::min(band, count[1] - (row - row % band)), row % band);
            let first = (row - above) * count[0] + above;
            Row { first, step: height, is_inside: above > 0 && above + 1 < height }
        });
        let mut cells =
            Self { per_metre, count, periodic, band, rows: rows.collect(), starts: Vec::new() };
        let order = cells.fill(positions);
        (cells, order)
    }

    /// Counts the discs of each cell, and returns their order.
    fn fill(&mut self, positions: &[[f64; 4]]) -> Vec<u32> {
        let cell_of = |&[x, y, ..]: &[f64; 4]| self.index(self.place([x, y])) as u32;
        let cells: Vec<u32> = positions.iter().map(cell_of).collect();
        let mut starts = vec![0_u32; self.count[0] * self.count[1] + 1];
        for &cell in &cells {
            starts[cell as usize + 1] += 1;
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut next = starts.clone();
        let mut order = vec![0; positions.len()];
        for (disc, &cell) in cells.iter().enumerate() {
            let place = &mut next[cell as usize];
            order[*place as usize] = disc as u32;
            *place += 1;
        }
        self.starts = starts;
        order
    }

    /// The cell of a point; points outside the box belong to the cells at its edge.
    #[inline]
    fn place(&self, point: [f64; 2]) -> Place {
        // A float that is negative or no number becomes 0 here.
        let along = |axis: usize| {
            Ord::min((point[axis] * self.per_metre[axis]) as u32 as usize, self.count[axis] - 1)
        };
        [along(0), along(1)]
    }

    #[inline]
    fn index(&self, [column, row]: Place) -> usize {
        self.rows[row].first + column * self.rows[row].step
    }

    /// Lists the runs of discs in the 3 x 3 block around a point's cell, column by column from the left. False if they were
    /// listed already.
    pub(super) fn around(&self, point: [f64; 2], found: &mut Runs) -> bool {
        let middle = self.place(point);
        if found.middle == Some(middle) {
            return false;
        }
        found.middle = Some(middle);
        found.runs.clear();
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
        true
    }

    /// Adds a run of cells, the first and the last by their numbers.
    #[inline]
    fn add(&self, [first, last]: [usize; 2], shift: [i8; 2], found: &mut Runs) {
        let discs = self.starts[first] as usize..self.starts[last + 1] as usize;
        if !discs.is_empty() {
            found.runs.push(Run { discs, shift });
        }
    }

    /// The same for a cell at the edge of the box or of a band.
    fn around_edge(&self, [column, row]: Place, found: &mut Runs) {
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
