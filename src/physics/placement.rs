//! Where discs stand at the start: random sequential addition and lattices in a rectangle.

use crate::random::Generator;

/// The rectangle that discs are placed in, walls at its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Lower left corner.
    pub min: [f64; 2],
    /// Upper right corner.
    pub max: [f64; 2],
}

/// Random sequential addition came to its end before all discs stood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Jammed {
    /// Discs that stood.
    pub placed: usize,
}

/// Trials a disc before random sequential addition gives up.
const TRIALS_PER_DISC: u32 = 2_000_000;

/// Places discs one after the other, each uniformly at random among all positions, drawn again while it overlaps another
/// disc (random sequential addition, Feder 1980). Returns the centers in the order of `radii`. Touching is no overlap.
///
/// # Errors
/// [`Jammed`] where a disc found no place in 2,000,000 trials.
pub fn random_sequential_addition(
    rectangle: Rectangle,
    radii: &[f64],
    generator: &mut Generator,
) -> Result<Vec<[f64; 2]>, Jammed> {
    random_sequential_addition_where(rectangle, radii, generator, |_, _| true)
}

/// The same, with trials drawn again where `is_allowed` says no to a center and radius: for containers that are no rectangle.
///
/// # Errors
/// [`Jammed`] where a disc found no place in 2,000,000 trials.
pub fn random_sequential_addition_where(
    rectangle: Rectangle,
    radii: &[f64],
    generator: &mut Generator,
    is_allowed: impl Fn([f64; 2], f64) -> bool,
) -> Result<Vec<[f64; 2]>, Jammed> {
    add_at_random(rectangle, Edges::Walls, radii, generator, is_allowed)
}

/// The same as [`random_sequential_addition`] where each edge of the rectangle is the opposite one. The rectangle is wider
/// than two discs.
///
/// # Errors
/// As [`random_sequential_addition`].
pub fn periodic_random_sequential_addition(
    rectangle: Rectangle,
    radii: &[f64],
    generator: &mut Generator,
) -> Result<Vec<[f64; 2]>, Jammed> {
    add_at_random(rectangle, Edges::Periodic, radii, generator, |_, _| true)
}

/// What is at the edges of the rectangle.
#[derive(Clone, Copy, PartialEq)]
enum Edges {
    Walls,
    Periodic,
}

fn add_at_random(
    rectangle: Rectangle,
    edges: Edges,
    radii: &[f64],
    generator: &mut Generator,
    is_allowed: impl Fn([f64; 2], f64) -> bool,
) -> Result<Vec<[f64; 2]>, Jammed> {
    let mut largest = 0.0;
    for &radius in radii {
        largest = if radius > largest { radius } else { largest };
    }
    let mut cells = Cells::new(rectangle, edges, 2.0 * largest, radii.len());
    let mut centers: Vec<[f64; 2]> = Vec::with_capacity(radii.len());
    for (index, &radius) in radii.iter().enumerate() {
        let kept_off = if edges == Edges::Walls { radius } else { 0.0 };
        let low = [rectangle.min[0] + kept_off, rectangle.min[1] + kept_off];
        let high = [rectangle.max[0] - kept_off, rectangle.max[1] - kept_off];
        if low[0] > high[0] || low[1] > high[1] {
            return Err(Jammed { placed: index });
        }
        let place = (0..TRIALS_PER_DISC).find_map(|_| {
            let trial =
                [generator.uniform_in(low[0], high[0]), generator.uniform_in(low[1], high[1])];
            (is_allowed(trial, radius) && cells.is_free(trial, radius, &centers, radii))
                .then_some(trial)
        });
        let Some(center) = place else { return Err(Jammed { placed: index }) };
        cells.insert(center, index);
        centers.push(center);
    }
    Ok(centers)
}

/// The first `count` sites of a square lattice that fills the rectangle evenly from below, row by row, for discs of one
/// radius; `None` where they do not fit without overlap.
#[must_use]
pub fn square_lattice(rectangle: Rectangle, radius: f64, count: usize) -> Option<Vec<[f64; 2]>> {
    let sides = [rectangle.max[0] - rectangle.min[0], rectangle.max[1] - rectangle.min[1]];
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

/// A grid whose cells are at least as wide as the largest distance of interest: neighbors stand in the 3 x 3 block.
struct Cells {
    origin: [f64; 2],
    side: [f64; 2],
    count: [usize; 2],
    edges: Edges,
    members: Vec<Vec<u32>>,
}

impl Cells {
    fn new(rectangle: Rectangle, edges: Edges, reach: f64, particles: usize) -> Self {
        // More cells than particles would only cost memory.
        let most = ((particles as f64).sqrt() as usize + 1) * 2;
        let along = |axis: usize| {
            let length = rectangle.max[axis] - rectangle.min[axis];
            ((length / reach) as usize).clamp(1, most)
        };
        let count = [along(0), along(1)];
        let side = [
            (rectangle.max[0] - rectangle.min[0]) / count[0] as f64,
            (rectangle.max[1] - rectangle.min[1]) / count[1] as f64,
        ];
        let members = vec![Vec::new(); count[0] * count[1]];
        Self { origin: rectangle.min, side, count, edges, members }
    }

    fn cell(&self, point: [f64; 2]) -> [usize; 2] {
        let along = |axis: usize| {
            (((point[axis] - self.origin[axis]) / self.side[axis]) as usize)
                .min(self.count[axis] - 1)
        };
        [along(0), along(1)]
    }

    fn insert(&mut self, center: [f64; 2], index: usize) {
        let [column, row] = self.cell(center);
        self.members[row * self.count[0] + column].push(index as u32);
    }

    fn is_free(&self, trial: [f64; 2], radius: f64, centers: &[[f64; 2]], radii: &[f64]) -> bool {
        let [column, row] = self.cell(trial);
        let columns = self.around(column, self.count[0]);
        for row in self.around(row, self.count[1]).into_iter().flatten() {
            for column in columns.into_iter().flatten() {
                for &other in &self.members[row * self.count[0] + column] {
                    let center = centers[other as usize];
                    let apart = [self.apart(trial, center, 0), self.apart(trial, center, 1)];
                    let reach = radius + radii[other as usize];
                    if apart[0] * apart[0] + apart[1] * apart[1] < reach * reach {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// An index and its two neighbors, where there are any.
    fn around(&self, index: usize, count: usize) -> [Option<usize>; 3] {
        if self.edges == Edges::Periodic {
            [Some((index + count - 1) % count), Some(index), Some((index + 1) % count)]
        } else {
            [index.checked_sub(1), Some(index), Some(index + 1).filter(|&next| next < count)]
        }
    }

    /// How far two points are apart along an axis; over an edge if that is nearer and may be.
    fn apart(&self, one: [f64; 2], other: [f64; 2], axis: usize) -> f64 {
        let apart = one[axis] - other[axis];
        if self.edges == Edges::Walls {
            return apart;
        }
        let side = self.side[axis] * self.count[axis] as f64;
        apart - side * (apart / side).round()
    }
}
