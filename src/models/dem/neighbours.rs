//! Which discs may touch: a half list with a skin, built from a grid of cells.
//!
//! The list holds every pair closer than touching plus the skin, and stays good until a disc has moved by half the skin.
//! Pairs are always visited in the order of their ids, and pairs apart add no force. So forces depend on the positions
//! alone and not on when the list was built: it is no part of the state.

/// Pairs of discs that may touch before one of them has moved by half the skin.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    /// Positions at which the list was built; empty before the first time.
    built_at: Vec<[f64; 2]>,
    /// Where a disc's partners begin in `partners`; one entry more than discs.
    row_starts: Vec<usize>,
    /// Partners with a higher id, ascending within a row.
    partners: Vec<u32>,
}

impl Neighbours {
    /// Builds the list anew where a disc has moved by more than half the skin since it was built.
    ///
    /// `sides` are the box's, from the origin; `skin` is above zero, all in m. Discs outside the box are found as well.
    pub fn refresh(&mut self, positions: &[[f64; 2]], radii: &[f64], sides: [f64; 2], skin: f64) {
        let limit = 0.25 * skin * skin;
        let is_good = self.built_at.len() == positions.len()
            && self.built_at.iter().zip(positions).all(|(then, now)| {
                let moved = [now[0] - then[0], now[1] - then[1]];
                moved[0] * moved[0] + moved[1] * moved[1] < limit
            });
        if !is_good {
            self.build(positions, radii, sides, skin);
        }
    }

    /// Partners of a disc with a higher id than its own, ascending.
    #[must_use]
    pub fn above(&self, disc: usize) -> &[u32] {
        &self.partners[self.row_starts[disc]..self.row_starts[disc + 1]]
    }

    fn build(&mut self, positions: &[[f64; 2]], radii: &[f64], sides: [f64; 2], skin: f64) {
        let mut largest = 0.0;
        for &radius in radii {
            largest = if radius > largest { radius } else { largest };
        }
        let cells = Cells::new(positions, sides, 2.0 * largest + skin);
        self.row_starts.clear();
        self.partners.clear();
        for (disc, &centre) in positions.iter().enumerate() {
            let row_start = self.partners.len();
            self.row_starts.push(row_start);
            cells.around(centre, |other| {
                let partner = other as usize;
                if partner <= disc {
                    return;
                }
                let apart = [positions[partner][0] - centre[0], positions[partner][1] - centre[1]];
                let reach = radii[disc] + radii[partner] + skin;
                if apart[0] * apart[0] + apart[1] * apart[1] < reach * reach {
                    self.partners.push(other);
                }
            });
            self.partners[row_start..].sort_unstable();
        }
        self.row_starts.push(self.partners.len());
        self.built_at.clear();
        self.built_at.extend_from_slice(positions);
    }
}

/// Discs sorted by cell; a cell is at least as wide as the reach, so that neighbours stand in the 3 x 3 block.
struct Cells {
    side: [f64; 2],
    count: [usize; 2],
    /// Where a cell's discs begin in `members`; one entry more than cells.
    starts: Vec<usize>,
    members: Vec<u32>,
}

impl Cells {
    fn new(positions: &[[f64; 2]], sides: [f64; 2], reach: f64) -> Self {
        // More cells than discs would only cost memory.
        let most = 2 * ((positions.len() as f64).sqrt() as usize + 1);
        let along = |axis: usize| {
            let fitting = (sides[axis] / reach) as usize;
            Ord::clamp(fitting, 1, most)
        };
        let count = [along(0), along(1)];
        let side = [sides[0] / count[0] as f64, sides[1] / count[1] as f64];
        let mut cells =
            Self { side, count, starts: vec![0; count[0] * count[1] + 1], members: Vec::new() };
        cells.sort(positions);
        cells
    }

    /// Counting sort of the discs by their cells.
    fn sort(&mut self, positions: &[[f64; 2]]) {
        let cells: Vec<usize> = positions.iter().map(|&centre| self.index(centre)).collect();
        for &cell in &cells {
            self.starts[cell + 1] += 1;
        }
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        let mut next = self.starts.clone();
        self.members = vec![0; positions.len()];
        for (disc, &cell) in cells.iter().enumerate() {
            self.members[next[cell]] = disc as u32;
            next[cell] += 1;
        }
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

    /// Visits all discs of the 3 x 3 block around a point.
    fn around(&self, point: [f64; 2], mut visit: impl FnMut(u32)) {
        let [column, row] = self.place(point);
        let first = column.saturating_sub(1);
        let last = Ord::min(column + 1, self.count[0] - 1);
        for row in row.saturating_sub(1)..=Ord::min(row + 1, self.count[1] - 1) {
            let row_start = row * self.count[0];
            // The cells of one row lie side by side in memory.
            let block = self.starts[row_start + first]..self.starts[row_start + last + 1];
            for &disc in &self.members[block] {
                visit(disc);
            }
        }
    }
}
