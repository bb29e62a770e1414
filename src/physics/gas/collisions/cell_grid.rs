//! Which discs may touch which: a grid over the container whose cells are wider than a disc.

/// Cells are wider than a disc by this much, so that rounding of a place never hides a neighbor.
const MARGIN: f64 = 1.0 + 1e-6;

/// Column and row of a cell.
pub(super) type Cell = [u32; 2];

/// The discs of each cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cells {
    /// Half the side of the square that the grid covers, m.
    half_side_m: f64,
    width_m: f64,
    /// Cells along a side.
    count: u32,
    members: Vec<Vec<u32>>,
}

impl Cells {
    /// Empty cells about the origin, about one for each disc.
    pub(super) fn new(half_side_m: f64, diameter_m: f64, discs: usize) -> Self {
        let side = 2.0 * half_side_m;
        let most = (discs as f64).sqrt() as u32 + 1;
        // A count too large for the type becomes its largest value.
        let fitting = (side / (diameter_m * MARGIN)) as u32;
        let count = if fitting < 1 {
            1
        } else if fitting < most {
            fitting
        } else {
            most
        };
        let members = vec![Vec::new(); count as usize * count as usize];
        Self { half_side_m, width_m: side / f64::from(count), count, members }
    }

    /// The cell of a place.
    pub(super) fn cell_of(&self, position: [f64; 2]) -> Cell {
        position.map(|component| {
            // Below zero the cast gives 0.
            let cell = ((component + self.half_side_m) / self.width_m) as u32;
            if cell < self.count { cell } else { self.count - 1 }
        })
    }

    /// Puts a disc into a cell.
    pub(super) fn insert(&mut self, cell: Cell, disc: u32) {
        let index = self.index(cell);
        self.members[index].push(disc);
    }

    /// Takes a disc out of its cell.
    pub(super) fn remove(&mut self, cell: Cell, disc: u32) {
        let index = self.index(cell);
        self.members[index].retain(|member| *member != disc);
    }

    /// The discs of a cell and of those around it.
    pub(super) fn around(&self, [column, row]: Cell) -> impl Iterator<Item = u32> + '_ {
        let last = self.count - 1;
        let span = move |index: u32| {
            index.saturating_sub(1)..=(if index < last { index + 1 } else { last })
        };
        span(row)
            .flat_map(move |row| span(column).map(move |column| [column, row]))
            .flat_map(|cell| self.members[self.index(cell)].iter().copied())
    }

    /// Time until a disc leaves its cell for another one, and which that is; [`f64::MAX`] where it stays.
    pub(super) fn crossing(
        &self,
        cell: Cell,
        position: [f64; 2],
        velocity: [f64; 2],
    ) -> (f64, Cell) {
        let mut soonest = (f64::MAX, cell);
        for axis in 0..2 {
            let forwards = velocity[axis] > 0.0;
            let at_edge = if forwards { cell[axis] + 1 >= self.count } else { cell[axis] == 0 };
            if velocity[axis] == 0.0 || at_edge {
                continue;
            }
            let border = if forwards { cell[axis] + 1 } else { cell[axis] };
            let line = f64::from(border) * self.width_m - self.half_side_m;
            let wait = (line - position[axis]) / velocity[axis];
            let wait = if wait > 0.0 { wait } else { 0.0 };
            if wait < soonest.0 {
                let mut next = cell;
                next[axis] = if forwards { cell[axis] + 1 } else { cell[axis] - 1 };
                soonest = (wait, next);
            }
        }
        soonest
    }

    fn index(&self, [column, row]: Cell) -> usize {
        row as usize * self.count as usize + column as usize
    }
}
