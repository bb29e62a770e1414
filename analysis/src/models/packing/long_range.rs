//! Order of a dense fluid in a periodic box beyond the neighbors of a disc: correlation of the hexatic order, and structure factor.

use crate::statistics::{Blocking, Entries, Estimate};
use std::f64::consts::PI;

/// Bins of g6(r) per diameter.
const BINS_PER_DIAMETER: f64 = 4.0;
/// Largest number of pairs that enter g6(r) of a frame, and of terms of S(Q) per direction: of more than 4000 discs, the pairs of some with
/// all others, and of many, only the longest waves.
const MAX_TERMS: usize = 16_000_000;
/// Outer radius of the rings in which g6(r) is compared, in diameters, from which the inner one begins beyond the neighbors.
const MIN_RADIUS_DIAMETERS: f64 = 6.0;
/// Largest wave number of S(Q), and the width of its bins, times a diameter.
const MAX_WAVE_NUMBER: f64 = 16.0;
const WAVE_NUMBER_BIN: f64 = 0.2;

/// Accumulated long-range order of equal discs.
#[derive(Clone, Debug, Default)]
pub(crate) struct LongRangeOrder {
    diameter: f64,
    region: [f64; 2],
    /// Sum of psi6 . psi6 over pairs, and their number, per bin of the distance.
    hexatic: Vec<[f64; 2]>,
    /// Mean psi6 . psi6 in the outer ring over that in the inner one.
    decay: Blocking,
    /// Sum of S(Q) and number of terms, per bin of the wave number.
    factors: Vec<[f64; 2]>,
    longest_waves: Blocking,
}

impl LongRangeOrder {
    /// Creates an empty record for discs in a periodic box with these sides.
    pub(super) fn new(diameter: f64, region: [f64; 2]) -> Self {
        let decay = Blocking::of(Entries::SampledFrames);
        Self {
            diameter,
            region,
            decay,
            longest_waves: Blocking::of(Entries::Frames),
            ..Self::default()
        }
    }

    /// Half of the shorter side: nearest images exist in all directions up to there.
    fn radius(&self) -> f64 {
        self.region[0].min(self.region[1]) / 2.0
    }

    /// Adds a frame.
    pub(super) fn add_frame(&mut self, centers: &[[f64; 2]], psi6: &[[f64; 2]]) {
        let most = MAX_TERMS / centers.len().max(1);
        self.add_hexatic_order(centers, psi6, most);
        let bins = (MAX_WAVE_NUMBER / WAVE_NUMBER_BIN) as usize;
        self.factors.resize(bins, [0.0; 2]);
        let [x, y] = self.region.map(|side| 2.0 * PI / side);
        for wave in [[x, 0.0], [0.0, y], [x, y], [x, -y]] {
            let step = libm::hypot(wave[0], wave[1]) * self.diameter;
            let waves = ((MAX_WAVE_NUMBER / step) as usize).min(most);
            for (index, factor) in structure_factors(centers, wave, waves).into_iter().enumerate() {
                let bin = ((index + 1) as f64 * step / WAVE_NUMBER_BIN) as usize;
                if let Some([sum, count]) = self.factors.get_mut(bin) {
                    *sum += factor;
                    *count += 1.0;
                }
            }
        }
    }

    /// Adds the pairs of the first discs, `references`, with all later ones.
    fn add_hexatic_order(&mut self, centers: &[[f64; 2]], psi6: &[[f64; 2]], references: usize) {
        let radius = self.radius();
        let bin_width = self.diameter / BINS_PER_DIAMETER;
        self.hexatic.resize((radius / bin_width) as usize, [0.0; 2]);
        let mut rings = [[0.0_f64; 2]; 2];
        let references = centers.iter().zip(psi6).take(references).enumerate();
        for (first, (center, own)) in references {
            for (other, psi) in centers.iter().zip(psi6).skip(first + 1) {
                let distance = self.distance(center, other);
                let product = own[0] * psi[0] + own[1] * psi[1];
                let ring = (2.0 * distance / radius) as usize;
                if ring < 2 && 4.0 * distance >= radius {
                    rings[ring] = [rings[ring][0] + product, rings[ring][1] + 1.0];
                }
                if let Some([sum, count]) = self.hexatic.get_mut((distance / bin_width) as usize) {
                    *sum += product;
                    *count += 1.0;
                }
            }
        }
        let is_filled = rings.iter().all(|[_, count]| *count > 0.0);
        if is_filled && radius >= MIN_RADIUS_DIAMETERS * self.diameter {
            let [inner, outer] = rings.map(|[sum, count]| sum / count);
            self.decay.add_amount(outer, inner);
        }
    }

    /// Distance of a center from the nearest image of another.
    fn distance(&self, from: &[f64; 2], to: &[f64; 2]) -> f64 {
        let [x, y] = [0, 1].map(|axis| {
            let (apart, side) = ((to[axis] - from[axis]).abs(), self.region[axis]);
            // Centers are inside of the box, so that the nearest image is at most one side away.
            if 2.0 * apart > side { side - apart } else { apart }
        });
        (x * x + y * y).sqrt()
    }

    /// Adds S(Q) of the longest wave along each side.
    pub(super) fn add_longest_waves(&mut self, centers: &[[f64; 2]]) {
        let [x, y] = self.region.map(|side| 2.0 * PI / side);
        let factors = [[x, 0.0], [0.0, y]].map(|wave| structure_factors(centers, wave, 1)[0]);
        self.longest_waves.add((factors[0] + factors[1]) / 2.0);
    }

    /// Mean S(Q) of the longest wave along each side.
    pub(super) fn longest_waves(&self) -> Option<Estimate> {
        self.longest_waves.estimate()
    }

    /// Mean squared wave number of these waves, times the squared diameter.
    pub(super) fn squared_wave_number(&self) -> f64 {
        let [x, y] = self.region.map(|side| 2.0 * PI * self.diameter / side);
        (x * x + y * y) / 2.0
    }

    /// The exponent of g6(r) ~ r^-exponent between a quarter and the whole of half the shorter side; `None` where the order
    /// decays to zero.
    pub(super) fn hexatic_exponent(&self) -> Option<Estimate> {
        let ratio = self.decay.estimate().filter(|ratio| ratio.value > 0.0)?;
        let value = -libm::log(ratio.value) / std::f64::consts::LN_2;
        // The exponent changes by 1/(ratio ln 2) per unit of the ratio.
        let slope = 1.0 / (ratio.value * std::f64::consts::LN_2);
        Some(ratio.times(slope).plus(value - ratio.value * slope))
    }

    /// g6(r): distance in diameters and mean, where it is positive.
    pub(crate) fn hexatic_correlation(&self) -> Vec<(f64, f64)> {
        let middle = |bin: usize| (bin as f64 + 0.5) / BINS_PER_DIAMETER;
        means(&self.hexatic, middle).filter(|(_, mean)| *mean > 0.0).collect()
    }

    /// S(Q): wave number times a diameter, and mean.
    pub(crate) fn structure_factor(&self) -> Vec<(f64, f64)> {
        means(&self.factors, |bin| (bin as f64 + 0.5) * WAVE_NUMBER_BIN).collect()
    }
}

/// Means of the bins with entries.
fn means(bins: &[[f64; 2]], place: impl Fn(usize) -> f64) -> impl Iterator<Item = (f64, f64)> {
    let filled = bins.iter().enumerate().filter(|(_, [_, count])| *count > 0.0);
    filled.map(move |(bin, [sum, count])| (place(bin), sum / count))
}

/// S(k Q) = |sum over discs of exp(i k Q . r)|^2 / n for k from 1.
fn structure_factors(centers: &[[f64; 2]], wave: [f64; 2], waves: usize) -> Vec<f64> {
    let mut sums = vec![[0.0_f64; 2]; waves];
    for center in centers {
        let phase = wave[0] * center[0] + wave[1] * center[1];
        let (sine, cosine) = libm::sincos(phase);
        let mut power = [1.0, 0.0];
        for sum in &mut sums {
            let [real, imaginary] = power;
            power = [real * cosine - imaginary * sine, real * sine + imaginary * cosine];
            *sum = [sum[0] + power[0], sum[1] + power[1]];
        }
    }
    let squares = sums.into_iter().map(|[real, imaginary]| real * real + imaginary * imaginary);
    squares.map(|square| square / centers.len() as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangular lattice of rows of discs of diameter 1, and its sides.
    fn lattice(columns: u32, rows: u32, pitch: f64) -> (Vec<[f64; 2]>, [f64; 2]) {
        let height = pitch * 0.75_f64.sqrt();
        let sides = [pitch * f64::from(columns), height * f64::from(rows)];
        let centers = (0..columns * rows).map(|index| {
            let (column, row) = (f64::from(index % columns), f64::from(index / columns));
            let shift = if (index / columns).is_multiple_of(2) { 0.0 } else { 0.5 };
            [pitch * (column + shift) - sides[0] / 2.0, height * row - sides[1] / 2.0]
        });
        (centers.collect(), sides)
    }

    /// Law: S(Q) of a lattice is the number of discs at a reciprocal vector and 0 between; that of points at random is 1 on average.
    /// Control: one disc that is moved.
    #[test]
    fn structure_factor_of_a_lattice_and_of_points_at_random_is_exact() {
        let (mut centers, sides) = lattice(16, 18, 1.2);
        let wave = [2.0 * PI / sides[0], 0.0];
        let factors = structure_factors(&centers, wave, 40);
        for (index, factor) in factors.iter().enumerate() {
            // The rows are shifted by half a pitch, so that along a row every second reciprocal vector is extinct.
            let expected = if (index + 1) % 32 == 0 { 288.0 } else { 0.0 };
            assert!((factor - expected).abs() < 1e-9, "{index}: {factor}");
        }
        centers[7][0] += 0.3;
        assert!(structure_factors(&centers, wave, 1)[0] > 1e-6, "control");
        let mut random = 12_345_u64;
        let mut draw = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut order = LongRangeOrder::new(1.0, [10.0, 10.0]);
        for _ in 0..2000 {
            let centers: Vec<[f64; 2]> = (0..50).map(|_| [10.0 * draw(), 10.0 * draw()]).collect();
            order.add_longest_waves(&centers);
        }
        // |sum|^2/n is exponential with a mean and standard deviation of 1.
        let mean = order.longest_waves().unwrap().value;
        assert!((mean - 1.0).abs() < 4.0 / 4000.0_f64.sqrt(), "{mean}");
    }

    /// Law: hexatic order that is the same everywhere has the exponent 0; order that is smaller by a factor of 2^-1/4 in discs that are twice as
    /// far from a reference disc has the exponent 1/4.
    /// Setup: only the first disc has an order other than the power of the distance from it, and only its pairs are added.
    #[test]
    fn exponent_is_that_of_the_order() {
        let (centers, sides) = lattice(32, 36, 1.1);
        let mut uniform = LongRangeOrder::new(1.0, sides);
        uniform.add_frame(&centers, &vec![[0.6, -0.8]; centers.len()]);
        assert!(uniform.hexatic_exponent().unwrap().value.abs() < 1e-12);
        assert!(uniform.hexatic_correlation().iter().all(|(_, mean)| (mean - 1.0).abs() < 1e-12));
        for power in [0.25, 0.5] {
            let mut order = LongRangeOrder::new(1.0, sides);
            let at = |center: &[f64; 2]| order.distance(&centers[0], center).max(1.0);
            let mut psi6: Vec<[f64; 2]> =
                centers.iter().map(|center| [libm::pow(at(center), -power), 0.3]).collect();
            psi6[0] = [1.0, 0.0];
            order.add_hexatic_order(&centers, &psi6, 1);
            let found = order.hexatic_exponent().unwrap().value;
            assert!((found - power).abs() < 0.02, "{power}: {found}");
        }
    }
}
