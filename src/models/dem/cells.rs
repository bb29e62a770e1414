//! A grid of cells at least as wide as the reach: neighbours stand in the 3 x 3 block.

/// Which directions of the box are periodic.
pub(super) type Periodic = [bool; 2];

/// Discs sorted by cell, row by row.
pub(super) struct Cells {
    side: [f64; 2],
    count: [usize; 2],
    periodic: Periodic,
    /// Where a cell's discs begin in the sorted order; one entry more than cells.
    starts: Vec<u32>,
}

/// A run of discs in the sorted order, and by how many box lengths they are shifted to stand beside the one that looks.
pub(super) struct Run {
    pub(super) discs: std::ops::Range<usize>,
    pub(super) shift: [i8; 2],
}

impl Cells {
    /// The grid, and the order that sorts the positions by cell; within a cell the order given is kept.
    pub(super) fn sort(
        positions: &[[f64; 4]],
        sides: [f64; 2],
        reach: f64,
        periodic: Periodic,
    ) -> (Self, Vec<u32>) {
        // More cells than discs would only cost memory.
        let most = 2 * ((positions.len() as f64).sqrt() as usize + 1);
        let along = |axis: usize| Ord::clamp((sides[axis] / reach) as usize, 1, most);
        let count = [along(0), along(1)];
        let side = [sides[0] / count[0] as f64, sides[1] / count[1] as f64];
        let mut cells = Self { side, count, periodic, starts: vec![0; count[0] * count[1] + 1] };
        for &[x, y, ..] in positions {
            let cell = cells.index([x, y]);
            cells.starts[cell + 1] += 1;
        }
        for cell in 1..cells.starts.len() {
            cells.starts[cell] += cells.starts[cell - 1];
        }
        let mut next = cells.starts.clone();
        let mut order = vec![0; positions.len()];
        for (disc, &[x, y, ..]) in positions.iter().enumerate() {
            let place = &mut next[cells.index([x, y])];
            order[*place as usize] = disc as u32;
            *place += 1;
        }
        (cells, order)
    }

    /// Column and row of a point; points outside the box belong to the cells at its edge.
    fn place(&self, point: [f64; 2]) -> [usize; 2] {
        // A float that is negative or no number becomes 0 here.
        let along =
            |axis: usize| Ord::min((point[axis] / self.side[axis]) as usize, self.count[axis] - 1);
        [along(0), along(1)]
    }

    fn index(&self, point: [f64; 2]) -> usize {
        let [column, row] = self.place(point);
        row * self.count[0] + column
    }

    /// Visits the runs of discs in the 3 x 3 block around a point, row by row from below.
    pub(super) fn around(&self, point: [f64; 2], mut visit: impl FnMut(Run)) {
        let [column, row] = self.place(point);
        let first = column.saturating_sub(1);
        let last = Ord::min(column + 1, self.count[0] - 1);
        for step in [-1_i8, 0, 1] {
            let Some((row, row_shift)) = self.beside(1, row, step) else { continue };
            let mut run = |from: usize, to: usize, shift: i8| {
                // The cells of one row lie side by side in memory.
                let cell = row * self.count[0];
                let discs = self.starts[cell + from] as usize..self.starts[cell + to + 1] as usize;
                visit(Run { discs, shift: [shift, row_shift] });
            };
            run(first, last, 0);
            for side in [-1_i8, 1] {
                if let Some((beyond, shift @ (-1 | 1))) = self.beside(0, column, side) {
                    run(beyond, beyond, shift);
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
