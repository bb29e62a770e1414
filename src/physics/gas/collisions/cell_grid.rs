//! Grid over the container whose cells are wider than a disc: discs in contact are in the same or adjacent cells.

/// Minimum width of a cell over the diameter of a disc, so that rounding of a position never hides a neighbor.
const MARGIN: f64 = 1.0 + 1e-6;

/// Column and row of a cell.
pub(super) type Cell = [u32; 2];

/// The discs of each cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CellGrid {
    /// Half the side of the square grid, m.
    half_side_m: f64,
    width_m: f64,
    /// Cells along a side.
    count: u32,
    members: Vec<Vec<u32>>,
}

impl CellGrid {
    /// Empty cells around the origin, about one per disc.
    pub(super) fn new(half_side_m: f64, diameter_m: f64, discs: usize) -> Self {
        let side = 2.0 * half_side_m;
        let max_count = (discs as f64).sqrt() as u32 + 1;
        // The cast saturates.
        let fitting = (side / (diameter_m * MARGIN)) as u32;
        let count = if fitting < 1 {
            1
        } else if fitting < max_count {
            fitting
        } else {
            max_count
        };
        let members = vec![Vec::new(); count as usize * count as usize];
        Self { half_side_m, width_m: side / f64::from(count), count, members }
    }

    /// Cell that contains a position.
    pub(super) fn cell_of(&self, position: [f64; 2]) -> Cell {
        position.map(|component| {
            // The cast of a negative number gives 0.
            let cell = ((component + self.half_side_m) / self.width_m) as u32;
            if cell < self.count { cell } else { self.count - 1 }
        })
    }

    /// Adds a disc to a cell.
    pub(super) fn insert(&mut self, cell: Cell, disc: u32) {
        let index = self.index(cell);
        self.members[index].push(disc);
    }

    /// Removes a disc from its cell.
    pub(super) fn remove(&mut self, cell: Cell, disc: u32) {
        let index = self.index(cell);
        self.members[index].retain(|member| *member != disc);
    }

    /// Discs in a cell and in the adjacent cells.
    pub(super) fn around(&self, [column, row]: Cell) -> impl Iterator<Item = u32> + '_ {
        let last = self.count - 1;
        let span = move |index: u32| {
            index.saturating_sub(1)..=(if index < last { index + 1 } else { last })
        };
        span(row)
            .flat_map(move |row| span(column).map(move |column| [column, row]))
            .flat_map(|cell| self.members[self.index(cell)].iter().copied())
    }

    /// Time until a disc enters another cell, and that cell; [`f64::MAX`] if it stays.
    pub(super) fn crossing(
        &self,
        cell: Cell,
        position: [f64; 2],
        velocity: [f64; 2],
    ) -> (f64, Cell) {
        let mut earliest = (f64::MAX, cell);
        for axis in 0..2 {
            let is_forward = velocity[axis] > 0.0;
            let is_at_edge =
                if is_forward { cell[axis] + 1 >= self.count } else { cell[axis] == 0 };
            if velocity[axis] == 0.0 || is_at_edge {
                continue;
            }
            let next_line = if is_forward { cell[axis] + 1 } else { cell[axis] };
            let boundary = f64::from(next_line) * self.width_m - self.half_side_m;
            let delay = (boundary - position[axis]) / velocity[axis];
            let delay = if delay > 0.0 { delay } else { 0.0 };
            if delay < earliest.0 {
                let mut next = cell;
                next[axis] = if is_forward { cell[axis] + 1 } else { cell[axis] - 1 };
                earliest = (delay, next);
            }
        }
        earliest
    }

    fn index(&self, [column, row]: Cell) -> usize {
        row as usize * self.count as usize + column as usize
    }
}
