//! The grid that keeps the search for partners local.

use super::events::Side;
use super::motion::Vector;
use serde::{Deserialize, Serialize};

/// Cells are wider than the contact distance by this factor: rounding of edges and crossing times hides no partner.
const MARGIN: f64 = 1.01;

/// Marks the end of a cell's list.
const NOBODY: u32 = u32::MAX;

/// A grid over the box. Its cells are wider than the contact distance, so that all discs that can touch a disc of a cell
/// before one of the two leaves its own stand in the 3 x 3 block around it. A disc changes its cell by an event, never by
/// its position. The order of discs within a cell has no influence on any result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Cells {
    origin: Vector,
    side: Vector,
    /// Columns and rows.
    count: [u32; 2],
    /// First disc of each cell.
    first: Vec<u32>,
    /// Of each disc: its column and row, and its neighbours in that cell's list.
    members: Vec<Member>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Member {
    cell: [u32; 2],
    previous: u32,
    next: u32,
}

impl Cells {
    /// Puts discs into the cells of a box that is centred on the origin. There is at most about one cell a disc: in dilute
    /// systems, where contact would do with smaller ones, discs would do little else than cross edges.
    pub(super) fn new(box_sides: Vector, contact_distance: f64, centres: &[Vector]) -> Self {
        let spread = (box_sides[0] * box_sides[1] / centres.len() as f64).sqrt();
        let narrowest = MARGIN * contact_distance;
        let width = if spread > narrowest { spread } else { narrowest };
        let along = |axis: usize| ((box_sides[axis] / width) as u32).max(1);
        let count = [along(0), along(1)];
        let mut cells = Self {
            origin: [-0.5 * box_sides[0], -0.5 * box_sides[1]],
            side: [box_sides[0] / f64::from(count[0]), box_sides[1] / f64::from(count[1])],
            count,
            first: vec![NOBODY; count[0] as usize * count[1] as usize],
            members: vec![Member { cell: [0, 0], previous: NOBODY, next: NOBODY }; centres.len()],
        };
        for (disc, &centre) in centres.iter().enumerate() {
            cells.members[disc].cell = cells.cell_of(centre);
            cells.link(disc as u32);
        }
        cells
    }

    /// Where the edge of a disc's cell is that its centre crosses next on that side; `None` where the wall comes first.
    pub(super) fn edge(&self, disc: u32, side: Side) -> Option<f64> {
        let axis = side.axis();
        let index = self.members[disc as usize].cell[axis];
        let edge = if side.is_upper() { index + 1 } else { index };
        (edge != 0 && edge != self.count[axis])
            .then(|| self.origin[axis] + f64::from(edge) * self.side[axis])
    }

    /// Moves a disc into the next cell on that side, which exists (see [`Self::edge`]).
    pub(super) fn cross(&mut self, disc: u32, side: Side) {
        self.unlink(disc);
        let index = &mut self.members[disc as usize].cell[side.axis()];
        *index = if side.is_upper() { *index + 1 } else { *index - 1 };
        self.link(disc);
    }

    /// Calls `visit` with every disc of the 3 x 3 block around a disc, the disc itself included.
    pub(super) fn for_each_near(&self, disc: u32, mut visit: impl FnMut(u32)) {
        let [column, row] = self.members[disc as usize].cell;
        let columns = column.saturating_sub(1)..(column + 2).min(self.count[0]);
        for row in row.saturating_sub(1)..(row + 2).min(self.count[1]) {
            for column in columns.clone() {
                let mut other = self.first[self.index([column, row])];
                while other != NOBODY {
                    visit(other);
                    other = self.members[other as usize].next;
                }
            }
        }
    }

    fn cell_of(&self, centre: Vector) -> [u32; 2] {
        let along = |axis: usize| {
            (((centre[axis] - self.origin[axis]) / self.side[axis]) as u32)
                .min(self.count[axis] - 1)
        };
        [along(0), along(1)]
    }

    fn index(&self, [column, row]: [u32; 2]) -> usize {
        row as usize * self.count[0] as usize + column as usize
    }

    fn link(&mut self, disc: u32) {
        let cell = self.index(self.members[disc as usize].cell);
        let next = std::mem::replace(&mut self.first[cell], disc);
        if next != NOBODY {
            self.members[next as usize].previous = disc;
        }
        let member = &mut self.members[disc as usize];
        (member.previous, member.next) = (NOBODY, next);
    }

    fn unlink(&mut self, disc: u32) {
        let Member { cell, previous, next } = self.members[disc as usize];
        if next != NOBODY {
            self.members[next as usize].previous = previous;
        }
        if previous == NOBODY {
            let cell = self.index(cell);
            self.first[cell] = next;
        } else {
            self.members[previous as usize].next = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Promise: a cell is wider than the contact distance, however dense the discs, unless the box has no second one; and
    /// there is no more than one cell a disc, or one row of cells as long as the discs are apart on average.
    #[test]
    fn cells_are_wider_than_contact() {
        for sides in [[10.0, 10.0], [40.0, 17.3], [1e5, 10.0]] {
            for contact_distance in [0.02, 1.0, 1.99, 9.9] {
                for discs in [1, 7, 400, 5000] {
                    let cells = Cells::new(sides, contact_distance, &vec![[0.0, 0.0]; discs]);
                    for axis in 0..2 {
                        assert!(cells.count[axis] == 1 || cells.side[axis] > contact_distance);
                    }
                    let one_row = (discs as f64 * sides[0] / sides[1]).sqrt();
                    assert!(cells.first.len() as f64 <= discs as f64 + one_row);
                }
            }
        }
    }
}
