//! Initial positions of discs: random sequential addition and square lattices in a rectangle.

use crate::cell_grid::{Cell, CellGrid};
use crate::cell_lists::{CellLists, NO_DISC};
use crate::memory::with_large_pages;
use crate::model::{Proceed, SetupError};
use crate::random::Generator;
use crate::simd::prefetch::prefetch;
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
pub enum Incomplete {
    /// A disc found no free position.
    Jammed {
        /// Discs that were placed.
        placed: usize,
    },
    /// The caller did not want to proceed.
    Stopped,
}

impl Incomplete {
    /// The error of a start; `jammed` is that of a jam after a number of discs.
    pub(crate) fn into_error(self, jammed: impl FnOnce(usize) -> SetupError) -> SetupError {
        match self {
            Self::Jammed { placed } => jammed(placed),
            Self::Stopped => SetupError::stopped(),
        }
    }
}

/// Trials per disc after which random sequential addition stops.
const MAX_TRIALS_PER_DISC: u32 = 2_000_000;

/// Places discs one after the other, each uniformly at random, and draws a position again while the disc overlaps another
/// one (random sequential addition; Feder, J. Theor. Biol. 87 (1980) 237) or `is_allowed` rejects its center and radius.
/// Returns the centers in the order of `radii`. Discs that touch do not overlap. A periodic rectangle is wider than two discs.
///
/// # Errors
/// A disc that found no free position in 2,000,000 trials. `proceed` is asked before each disc.
pub fn random_sequential_addition(
    rectangle: Rectangle,
    boundary: Boundary,
    radii: &[f64],
    generator: &mut Generator,
    is_allowed: impl Fn([f64; 2], f64) -> bool,
    proceed: Proceed<'_>,
) -> Result<Vec<[f64; 2]>, Incomplete> {
    let mut placed = PlacedDiscs::new(rectangle, boundary, radii);
    let mut upcoming = (radii.len() >= PREFETCHED_FROM).then(|| UpcomingTrials::of(generator));
    for (index, &radius) in radii.iter().enumerate() {
        let margin = if boundary == Boundary::Walls { radius } else { 0.0 };
        let low = [rectangle.min[0] + margin, rectangle.min[1] + margin];
        let high = [rectangle.max[0] - margin, rectangle.max[1] - margin];
        if low[0] > high[0] || low[1] > high[1] {
            return Err(Incomplete::Jammed { placed: index });
        }
        if !proceed(index as f64 / radii.len() as f64) {
            return Err(Incomplete::Stopped);
        }
        let free = (0..MAX_TRIALS_PER_DISC).find_map(|_| {
            if let Some(upcoming) = &mut upcoming {
                upcoming.prefetch(&placed, [low, high]);
            }
            let trial = drawn_in([low, high], generator);
            (is_allowed(trial, radius) && placed.is_free(trial, radius)).then_some(trial)
        });
        let Some(center) = free else { return Err(Incomplete::Jammed { placed: index }) };
        placed.push(center, radius);
    }
    Ok(placed.discs.iter().map(|&[x, y, ..]| [x, y]).collect())
}

/// A point drawn uniformly between a lower left and an upper right corner.
#[inline]
fn drawn_in([low, high]: [[f64; 2]; 2], generator: &mut Generator) -> [f64; 2] {
    [generator.uniform_in(low[0], high[0]), generator.uniform_in(low[1], high[1])]
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

/// Number of discs from which the memory of a trial is requested in advance: fewer discs fit into the cache.
const PREFETCHED_FROM: usize = 1 << 14;

/// Number of trials between the request of a trial's cells and that of their discs, and between this and the trial.
const STAGE: usize = 8;

/// The cells of a 3 x 3 block from the center to the corners: an overlap is found sooner.
const OVERLAP_LIKELY_FIRST: [usize; 9] = [4, 1, 3, 5, 7, 0, 2, 6, 8];

/// The cells of the next trials, which a copy of the generator draws in advance. Their memory is requested in two stages, because
/// trials lie anywhere in the box. The margin of the present disc is used for all, so that a cell may be another one; this costs time only.
struct UpcomingTrials {
    generator: Generator,
    cells: [Cell; 2 * STAGE],
    trial: usize,
}

impl UpcomingTrials {
    fn of(generator: &Generator) -> Self {
        let mut upcoming =
            Self { generator: generator.clone(), cells: [[0; 2]; 2 * STAGE], trial: 0 };
        // The first trials are not requested: the copy is ahead of the generator by two stages.
        for _ in 0..2 * STAGE {
            drawn_in([[0.0; 2], [1.0; 2]], &mut upcoming.generator);
        }
        upcoming
    }

    #[inline]
    fn prefetch(&mut self, placed: &PlacedDiscs<'_>, corners: [[f64; 2]; 2]) {
        let (first, second) = (self.trial % (2 * STAGE), (self.trial + STAGE) % (2 * STAGE));
        let cell = placed.cells.grid.cell_at(drawn_in(corners, &mut self.generator));
        self.cells[first] = cell;
        let (slots, rows, columns) = placed.cells.block_indices(cell);
        for row in rows {
            prefetch(slots, row + columns[0]);
            prefetch(slots, row + columns[2]);
        }
        for slots in placed.cells.block_slots(self.cells[second]) {
            for &disc in slots.iter().take_while(|&&disc| disc != NO_DISC) {
                prefetch(&placed.discs, disc as usize);
            }
        }
        self.trial += 1;
    }
}

/// The discs that have been placed, by cell.
struct PlacedDiscs<'a> {
    rectangle: Rectangle,
    boundary: Boundary,
    radii: &'a [f64],
    /// Center and radius of each disc, and a number that completes half a cache line.
    discs: Vec<[f64; 4]>,
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
        let discs = with_large_pages(radii.len());
        Self { rectangle, boundary, radii, discs, cells: CellLists::new(grid) }
    }

    /// Places the next disc.
    fn push(&mut self, center: [f64; 2], radius: f64) {
        let cell = self.cells.grid.cell_at(center);
        self.cells.insert(self.discs.len() as u32, cell, self.radii.len());
        self.discs.push([center[0], center[1], radius, 0.0]);
    }

    /// Whether a disc would overlap none of those that have been placed.
    fn is_free(&self, center: [f64; 2], radius: f64) -> bool {
        let cell = self.cells.grid.cell_at(center);
        if self.cells.has_overflow() {
            return self
                .cells
                .discs_around(cell)
                .all(|other| !self.overlaps(other, center, radius));
        }
        let block = self.cells.block_slots(cell);
        OVERLAP_LIKELY_FIRST.iter().all(|&index| {
            let mut discs = block[index].iter().take_while(|&&disc| disc != NO_DISC);
            discs.all(|&other| !self.overlaps(other, center, radius))
        })
    }

    /// Whether a disc would overlap one that has been placed.
    #[inline]
    fn overlaps(&self, other: u32, center: [f64; 2], radius: f64) -> bool {
        let [x, y, other_radius, _] = self.discs[other as usize];
        let r = [0, 1].map(|axis| self.separation(center, [x, y], axis));
        let contact_distance = radius + other_radius;
        r[0] * r[0] + r[1] * r[1] < contact_distance * contact_distance
    }

    /// The separation of two points along an axis; in a periodic rectangle, that of the nearest images.
    fn separation(&self, first: [f64; 2], second: [f64; 2], axis: usize) -> f64 {
        let separation = first[axis] - second[axis];
        if self.boundary == Boundary::Walls {
            return separation;
        }
        let side = self.rectangle.sides()[axis];
        separation - side * libm::round(separation / side)
    }
}
