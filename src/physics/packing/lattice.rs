//! Hexagonal lattices: the densest packings of equal discs in a box.

use super::motion::Vector;

/// The rows of a hexagonal lattice in a box: every second row is shifted by half a pitch.
#[derive(Clone, Copy)]
struct HexagonalRows {
    /// Distance of neighbors in a row, at least one diameter.
    pitch: f64,
    /// Discs in the first, third, … row.
    full: usize,
    /// Discs in the second, fourth, … row: the same number, or one less.
    shifted: usize,
    /// Largest number of rows that fit.
    rows: usize,
}

impl HexagonalRows {
    /// The rows along the first side of a box that is wider and higher than one disc.
    fn new(sides: [f64; 2], radius: f64) -> Self {
        let room = [sides[0] - 2.0 * radius, sides[1] - 2.0 * radius];
        let full = (room[0] / (2.0 * radius)) as usize + 1;
        // The largest pitch at which the last disc of a shifted row fits.
        let widest = room[0] / (full as f64 - 0.5);
        let rows = (room[1] / (3.0_f64.sqrt() * radius)) as usize + 1;
        if widest >= 2.0 * radius {
            Self { pitch: widest, full, shifted: full, rows }
        } else {
            let pitch = if full > 1 { room[0] / (full as f64 - 1.0) } else { room[0] };
            Self { pitch, full, shifted: full - 1, rows }
        }
    }

    fn in_row(&self, row: usize) -> usize {
        if row.is_multiple_of(2) { self.full } else { self.shifted }
    }

    fn capacity(&self) -> usize {
        self.rows.div_ceil(2) * self.full + self.rows / 2 * self.shifted
    }

    /// The first `count` sites, row by row from below, in the fewest rows, which are spread over the height.
    fn sites(&self, sides: [f64; 2], radius: f64, count: usize) -> Vec<Vector> {
        let (mut needed, mut capacity) = (0, 0);
        while capacity < count {
            capacity += self.in_row(needed);
            needed += 1;
        }
        let room = sides[1] - 2.0 * radius;
        let spacing = if needed > 1 { room / (needed as f64 - 1.0) } else { 0.0 };
        let corner = [radius - 0.5 * sides[0], radius - 0.5 * sides[1]];
        (0..needed)
            .flat_map(|row| {
                let shift = if row.is_multiple_of(2) { 0.0 } else { 0.5 };
                (0..self.in_row(row)).map(move |column| {
                    [
                        corner[0] + (column as f64 + shift) * self.pitch,
                        corner[1] + row as f64 * spacing,
                    ]
                })
            })
            .take(count)
            .collect()
    }
}

/// Places `count` discs on a hexagonal lattice in a box that is centered on the origin, with rows along x if the discs fit,
/// else along y; `None` if neither fits. Neighbors are at least one diameter apart, up to rounding.
pub(super) fn hexagonal_lattice(sides: [f64; 2], radius: f64, count: usize) -> Option<Vec<Vector>> {
    let turned = [sides[1], sides[0]];
    let (along_x, along_y) =
        (HexagonalRows::new(sides, radius), HexagonalRows::new(turned, radius));
    if count <= along_x.capacity() {
        Some(along_x.sites(sides, radius, count))
    } else if count <= along_y.capacity() {
        let sites = along_y.sites(turned, radius, count);
        Some(sites.into_iter().map(|[y, x]| [x, y]).collect())
    } else {
        None
    }
}

/// The largest number of discs that [`hexagonal_lattice`] places in a box.
pub(super) fn max_in_hexagonal_lattice(sides: [f64; 2], radius: f64) -> usize {
    let along_x = HexagonalRows::new(sides, radius).capacity();
    along_x.max(HexagonalRows::new([sides[1], sides[0]], radius).capacity())
}

/// Places `count` discs on a hexagonal lattice that continues across the edges of a periodic box centered on the origin. It
/// has an even number of rows of equal length, of which the last one may not be full. Returns `None` if it does not fit.
pub(super) fn periodic_hexagonal_lattice(
    sides: [f64; 2],
    radius: f64,
    count: usize,
) -> Option<Vec<Vector>> {
    let diameter = 2.0 * radius;
    let most_rows = (sides[1] / (0.5 * 3.0_f64.sqrt() * diameter)) as usize;
    let most_columns = (sides[0] / diameter) as usize;
    let rows = (1..=most_rows / 2).map(|half| 2 * half).find(|&rows| {
        let columns = count.div_ceil(rows);
        let pitch = [0.5 * sides[0] / columns as f64, sides[1] / rows as f64];
        columns <= most_columns && pitch[0] * pitch[0] + pitch[1] * pitch[1] >= diameter * diameter
    })?;
    let columns = count.div_ceil(rows);
    let pitch = [sides[0] / columns as f64, sides[1] / rows as f64];
    Some(
        (0..count)
            .map(|site| {
                let (row, column) = (site / columns, site % columns);
                let shift = if row.is_multiple_of(2) { 0.25 } else { 0.75 };
                [
                    (column as f64 + shift) * pitch[0] - 0.5 * sides[0],
                    (row as f64 + 0.5) * pitch[1] - 0.5 * sides[1],
                ]
            })
            .collect(),
    )
}
