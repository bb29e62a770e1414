//! Initial positions of discs: random sequential addition and square lattices in a rectangle.

use crate::cell_grid::CellGrid;
use crate::cell_lists::CellLists;
use crate::random::Generator;
use kinetoscope_manifest::model::Boundary;

/// The rectangle in which discs are placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Lower left corner.
    pub min: [f64; 2],
    /// Upper right corner.
    pub max: [f64; 2],
}

impl Rectangle {
    fn sides(&self) -> [f64; 2] {
        [self.max[0] - self.min[0], self.max[1] - self.min[1]]
    }
}

/// Random sequential addition stopped before all discs were placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Jammed {
    /// Discs that were placed.
    pub placed: usize,
}

/// Trials per disc after which random sequential addition stops.
const MAX_TRIALS_PER_DISC: u32 = 2_000_000;

/// Places discs one after the other, each uniformly at random, and draws a position again while the disc overlaps another
/// one (random sequential addition; Feder, J. Theor. Biol. 87 (1980) 237) or `is_allowed` rejects its center and radius.
/// Returns the centers in the order of `radii`. Discs that touch do not overlap. A periodic rectangle is wider than two discs.
///
/// # Errors
/// [`Jammed`] if a disc found no free position in 2,000,000 trials.
pub fn random_sequential_addition(
    rectangle: Rectangle,
    boundary: Boundary,
    radii: &[f64],
    generator: &mut Generator,
    is_allowed: impl Fn([f64; 2], f64) -> bool,
) -> Result<Vec<[f64; 2]>, Jammed> {
    let mut placed = PlacedDiscs::new(rectangle, boundary, radii);
    for (index, &radius) in radii.iter().enumerate() {
        let margin = if boundary == Boundary::Walls { radius } else { 0.0 };
        let low = [rectangle.min[0] + margin, rectangle.min[1] + margin];
        let high = [rectangle.max[0] - margin, rectangle.max[1] - margin];
        if low[0] > high[0] || low[1] > high[1] {
            return Err(Jammed { placed: index });
        }
        let free = (0..MAX_TRIALS_PER_DISC).find_map(|_| {
            let trial =
                [generator.uniform_in(low[0], high[0]), generator.uniform_in(low[1], high[1])];
            (is_allowed(trial, radius) && placed.is_free(trial, radius)).then_some(trial)
        });
        let Some(center) = free else { return Err(Jammed { placed: index }) };
        placed.push(center);
    }
    Ok(placed.centers)
}

/// Returns the first `count` sites of a square lattice of discs of one radius, row by row from below, spread over the
/// rectangle; `None` if they do not fit without overlap.
#[must_use]
pub fn square_lattice(rectangle: Rectangle, radius: f64, count: usize) -> Option<Vec<[f64; 2]>> {
    let sides = rectangle.sides();
    let most = [(sides[0] / (2.0 * radius)) as usize, (sides[1] / (2.0 * radius)) as usize];
    if most[0].saturating_mul(most[1]) < count || count == 0 {
        return None;
    }
    let wanted = (count as f64 * sides[0] / sides[1]).sqrt().ceil() as usize;
    let columns = wanted.max(count.div_ceil(most[1])).min(most[0]);
    let rows = count.div_ceil(columns);
    let pitch = [sides[0] / columns as f64, sides[1] / rows as f64];
    Some(
        (0..count)
            .map(|site| {
                let (row, column) = (site / columns, site % columns);
                [
                    rectangle.min[0] + (column as f64 + 0.5) * pitch[0],
                    rectangle.min[1] + (row as f64 + 0.5) * pitch[1],
                ]
            })
            .collect(),
    )
}

/// The discs that have been placed, by cell.
struct PlacedDiscs<'a> {
    rectangle: Rectangle,
    boundary: Boundary,
    radii: &'a [f64],
    centers: Vec<[f64; 2]>,
    cells: CellLists,
}

impl<'a> PlacedDiscs<'a> {
    fn new(rectangle: Rectangle, boundary: Boundary, radii: &'a [f64]) -> Self {
        let mut max_radius = 0.0;
        for &radius in radii {
            max_radius = if radius > max_radius { radius } else { max_radius };
        }
        // More cells than discs would only cost memory.
        let most = ((radii.len() as f64).sqrt() as u32 + 1).saturating_mul(2);
        let sides = rectangle.sides();
        let counts = sides.map(|side| ((side / (2.0 * max_radius)) as u32).min(most));
        let grid = CellGrid::new(rectangle.min, sides, counts, boundary == Boundary::Periodic);
        let centers = Vec::with_capacity(radii.len());
        Self { rectangle, boundary, radii, centers, cells: CellLists::new(grid) }
    }

    /// Places the next disc.
    fn push(&mut self, center: [f64; 2]) {
        let cell = self.cells.grid.cell_at(center);
        self.cells.insert(self.centers.len() as u32, cell, self.radii.len());
        self.centers.push(center);
    }

    /// Whether a disc would overlap none of those that have been placed.
    fn is_free(&self, center: [f64; 2], radius: f64) -> bool {
        let cell = self.cells.grid.cell_at(center);
        self.cells.discs_around(cell).all(|other| {
            let other_center = self.centers[other as usize];
            let r = [0, 1].map(|axis| self.separation(center, other_center, axis));
            let contact_distance = radius + self.radii[other as usize];
            r[0] * r[0] + r[1] * r[1] >= contact_distance * contact_distance
        })
    }

    /// The separation of two points along an axis; in a periodic rectangle, that of the nearest images.
    fn separation(&self, first: [f64; 2], second: [f64; 2], axis: usize) -> f64 {
        let separation = first[axis] - second[axis];
        if self.boundary == Boundary::Walls {
            return separation;
        }
        let side = self.rectangle.sides()[axis];
        separation - side * (separation / side).round()
    }
}
