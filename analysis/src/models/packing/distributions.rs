//! Distributions over discs and frames: speeds, and local packing fractions.

use kinetoscope_recording::reader::StateTable;
use std::f64::consts::PI;

/// Width of the bins of the speed, and their number, in units of the root of the granular temperature of the frame.
const SPEED_BIN: f64 = 0.1;
const SPEED_BINS: usize = 50;
/// Smallest side of a cell in which discs are counted, in diameters. In a dense fluid, it then contains about 20 discs.
const CELL_DIAMETERS: f64 = 5.0;
/// Smallest number of cells whose packing fractions are a distribution.
const MIN_CELLS: f64 = 4.0;

/// Counts of speeds and of discs per cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Distributions {
    discs: f64,
    sides: [f64; 2],
    /// Diameter of equal discs; `None` without one, so that discs are not counted by cell.
    diameter: Option<f64>,
    speeds: Vec<u64>,
    /// Number of cells by the number of discs in them.
    cells: Vec<u64>,
}

impl Distributions {
    /// Creates empty distributions of this many discs in a box that is centered at the origin.
    pub(super) fn new(discs: f64, sides: [f64; 2], diameter: Option<f64>) -> Self {
        Self { discs, sides, diameter, ..Self::default() }
    }

    /// Adds a frame.
    pub(super) fn add_frame(&mut self, state: &StateTable) {
        let columns = |names: [&str; 2]| {
            let [first, second] = names.map(|name| state.column(name));
            Some(first?.zip(second?).map(|(x, y)| [x, y]).collect::<Vec<[f64; 2]>>())
        };
        if let Some(velocities) = columns(["vx", "vy"]) {
            self.add_speeds(&velocities);
        }
        if let Some(centers) = columns(["x", "y"]) {
            self.add_centers(&centers);
        }
    }

    fn add_speeds(&mut self, velocities: &[[f64; 2]]) {
        let square = |[x, y]: &[f64; 2]| x * x + y * y;
        let sum = velocities.iter().map(square).sum::<f64>();
        if sum.is_nan() || sum <= 0.0 {
            return;
        }
        let temperature = sum / (2.0 * velocities.len() as f64);
        self.speeds.resize(SPEED_BINS, 0);
        for velocity in velocities {
            let bin = (square(velocity) / temperature).sqrt() / SPEED_BIN;
            if let Some(count) = self.speeds.get_mut(bin as usize) {
                *count += 1;
            }
        }
    }

    fn add_centers(&mut self, centers: &[[f64; 2]]) {
        let Some([columns, rows]) = self.columns_and_rows() else { return };
        let mut counts = vec![0_usize; columns * rows];
        let place = |coordinate: f64, side: f64, number: usize| {
            // A center outside of the box, as in a foreign file, is assigned to the outermost cell: `as` saturates.
            (((coordinate / side + 0.5) * number as f64) as usize).min(number - 1)
        };
        for [x, y] in centers {
            let column = place(*x, self.sides[0], columns);
            counts[place(*y, self.sides[1], rows) * columns + column] += 1;
        }
        for count in counts {
            self.cells.resize(self.cells.len().max(count + 1), 0);
            self.cells[count] += 1;
        }
    }

    /// Number of cells along each side; `None` if there would be too few, or more than discs.
    fn columns_and_rows(&self) -> Option<[usize; 2]> {
        let cell = CELL_DIAMETERS * self.diameter?;
        let [columns, rows] = self.sides.map(|side| (side / cell).floor());
        (MIN_CELLS..=self.discs)
            .contains(&(columns * rows))
            .then_some([columns as usize, rows as usize])
    }

    /// Density of the speed over the root of the temperature, with the standard error of its count.
    pub(super) fn speeds(&self) -> Vec<(f64, f64, f64)> {
        let all = self.speeds.iter().sum::<u64>() as f64 * SPEED_BIN;
        let density = |(bin, count): (usize, &u64)| {
            let count = *count as f64;
            ((bin as f64 + 0.5) * SPEED_BIN, count / all, count.sqrt() / all)
        };
        self.speeds.iter().enumerate().map(density).collect()
    }

    /// Packing fraction of the discs with their centers in a cell, fraction of the cells with it, and that of points at random with the same mean
    /// number per cell.
    pub(super) fn local_packing_fractions(&self) -> Vec<[f64; 3]> {
        let (Some(numbers), Some(diameter)) = (self.columns_and_rows(), self.diameter) else {
            return Vec::new();
        };
        let cell = (self.sides[0] / numbers[0] as f64) * (self.sides[1] / numbers[1] as f64);
        let all = self.cells.iter().sum::<u64>() as f64;
        let discs =
            self.cells.iter().enumerate().map(|(discs, cells)| discs as f64 * *cells as f64);
        let mean = discs.sum::<f64>() / all;
        let mut poisson = libm::exp(-mean);
        let mut row = |(discs, cells): (usize, &u64)| {
            let at_random = poisson;
            poisson *= mean / (discs as f64 + 1.0);
            [discs as f64 * PI / 4.0 * diameter * diameter / cell, *cells as f64 / all, at_random]
        };
        self.cells.iter().enumerate().map(&mut row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Law: the mean of the local packing fractions is that of the box; where half of the box is denser, they have two values.
    /// Control: the other half of the box is as dense.
    #[test]
    fn local_packing_fractions_have_the_mean_of_the_box() {
        // 20 x 20 squares of side 1, which are cells of 5 x 5; discs with a diameter of 1 in all of them, or in two of five rows of the left half.
        let squares =
            (0..400).map(|index| [f64::from(index % 20) - 9.5, f64::from(index / 20) - 9.5]);
        for (is_half, peaks) in [(true, vec![10.0, 25.0]), (false, vec![25.0])] {
            let centers: Vec<[f64; 2]> = squares
                .clone()
                .filter(|[x, y]| !is_half || *x > 0.0 || (y + 9.5).rem_euclid(5.0) < 1.5)
                .collect();
            let mut found = Distributions::new(400.0, [20.0, 20.0], Some(1.0));
            found.add_centers(&centers);
            let rows = found.local_packing_fractions();
            let mean = rows.iter().map(|[fraction, cells, _]| fraction * cells).sum::<f64>();
            let expected = centers.len() as f64 * PI / 4.0 / 400.0;
            assert!((mean - expected).abs() < 1e-12, "{mean} {expected}");
            let filled = rows.iter().filter(|[_, cells, _]| *cells > 0.0);
            let filled: Vec<f64> = filled.map(|[fraction, ..]| fraction * 100.0 / PI).collect();
            assert!(filled.iter().zip(&peaks).all(|(a, b)| (a - b).abs() < 1e-12), "{filled:?}");
            assert_eq!(filled.len(), peaks.len());
        }
        for sides in [[9.0, 19.0], [1e5, 1e5]] {
            let mut found = Distributions::new(400.0, sides, Some(1.0));
            found.add_centers(&[[0.0, 0.0]]);
            assert!(found.local_packing_fractions().is_empty(), "{sides:?}");
        }
    }

    /// Law: the speed over the root of the temperature has a mean square of 2 and the density of the counts an integral of 1.
    #[test]
    fn speeds_are_in_units_of_the_temperature() {
        let mut found = Distributions::new(3.0, [20.0, 20.0], None);
        found.add_speeds(&[[3.0, 0.0], [0.0, 4.0], [5.0, 0.0]]);
        let rows = found.speeds();
        let moments = rows.iter().fold([0.0; 2], |[all, square], (speed, density, _)| {
            [all + density * SPEED_BIN, square + density * SPEED_BIN * speed * speed]
        });
        assert!((moments[0] - 1.0).abs() < 1e-12 && (moments[1] - 2.0).abs() < 0.1, "{moments:?}");
    }
}
