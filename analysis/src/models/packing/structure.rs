//! Structure of equal discs: pair correlation function g(r) and bond-orientational order psi6, over sampled frames.

use super::long_range::LongRangeOrder;
use crate::statistics::{Blocking, Entries, Estimate};
use kinetoscope_recording::reader::StateTable;
use std::f64::consts::PI;

/// Bins of g(r) per diameter.
const BINS_PER_DIAMETER: usize = 20;
/// Range of g(r) in diameters.
const REACH_DIAMETERS: usize = 5;
/// Maximum distance of neighbors in diameters, between the first and second shell of a hexagonal lattice.
const NEIGHBOR_DIAMETERS: f64 = 1.5;
/// Maximum distance of discs near contact, in diameters.
const NEAR_CONTACT_DIAMETERS: f64 = 1.1;
/// Packing fraction from which the order beyond the next neighbors is measured.
pub(super) const MIN_LIQUID_FRACTION: f64 = 0.25;
/// Width in diameters of the three shells outside of a disc from which g(r) is extrapolated to contact.
pub(super) const SHELL_DIAMETERS: f64 = 0.03;
/// Weights of the mean g(r) of these shells: the value at contact of the parabola with these means.
const SHELL_WEIGHTS: [f64; 3] = [11.0 / 6.0, -7.0 / 6.0, 2.0 / 6.0];

/// Accumulated structure of equal discs in a box.
#[derive(Clone, Debug, Default)]
pub(crate) struct Structure {
    diameter: f64,
    /// Lower left corner and sides of the region that the centers can occupy.
    corner: [f64; 2],
    region: [f64; 2],
    /// Whether the region is periodic.
    periodic: bool,
    frames: u64,
    /// Sum over frames: pairs per bin over those of the same number of random points.
    correlation: Vec<f64>,
    near_contact: Blocking,
    at_contact: Blocking,
    psi6_global: Blocking,
    psi6_local: Blocking,
    pub(super) long_range: LongRangeOrder,
}

impl Structure {
    /// Creates an empty structure for discs of this radius in a box with these sides, centered at the origin.
    pub(super) fn new(radius: f64, sides: [f64; 2], periodic: bool) -> Self {
        let kept_off = if periodic { 0.0 } else { 2.0 * radius };
        let region = sides.map(|side| side - kept_off);
        Self {
            diameter: 2.0 * radius,
            corner: region.map(|side| -side / 2.0),
            region,
            periodic,
            near_contact: Blocking::of(Entries::SampledFrames),
            at_contact: Blocking::of(Entries::SampledFrames),
            psi6_global: Blocking::of(Entries::SampledFrames),
            psi6_local: Blocking::of(Entries::SampledFrames),
            long_range: LongRangeOrder::new(2.0 * radius, region),
            ..Self::default()
        }
    }

    /// Number of sampled frames.
    pub(super) const fn frames(&self) -> u64 {
        self.frames
    }

    /// Samples a frame.
    pub(super) fn add_frame(&mut self, state: &StateTable) {
        let centers = centers_of(state);
        // The region must contain a ring of the full range around its middle.
        let widest = self.region[0].min(self.region[1]) / if self.periodic { 2.0 } else { 1.0 };
        let reach = (REACH_DIAMETERS as f64).min((widest / self.diameter).floor());
        let bins = reach as usize * BINS_PER_DIAMETER;
        if centers.len() < 2 || reach < 2.0 {
            return;
        }
        let bin_width = self.diameter / BINS_PER_DIAMETER as f64;
        let mut pairs = vec![0_u64; bins];
        let mut bonds = vec![[0.0_f64; 3]; centers.len()];
        let near = NEIGHBOR_DIAMETERS * self.diameter;
        let (mut close, mut shells) = (0_u64, [0_u64; SHELL_WEIGHTS.len()]);
        let shell_width = SHELL_DIAMETERS * self.diameter;
        self.for_each_pair(&centers, reach * self.diameter, |first, second, apart| {
            let square = apart[0] * apart[0] + apart[1] * apart[1];
            // Rounding can move touching discs closer than a diameter.
            let distance = square.sqrt().max(self.diameter);
            close += u64::from(distance < NEAR_CONTACT_DIAMETERS * self.diameter);
            if let Some(count) = pairs.get_mut((distance / bin_width) as usize) {
                *count += 1;
            }
            if let Some(count) = shells.get_mut(((distance - self.diameter) / shell_width) as usize)
            {
                *count += 1;
            }
            if distance < near && square > 0.0 {
                // exp(6 i theta) is equal for both directions of a bond.
                let bond = sixth_power(apart.map(|part| part / square.sqrt()));
                for disc in [first, second] {
                    bonds[disc][0] += bond[0];
                    bonds[disc][1] += bond[1];
                    bonds[disc][2] += 1.0;
                }
            }
        });
        self.add_pairs(&pairs, close, bin_width, centers.len() as f64);
        self.add_shells(shells, centers.len() as f64);
        let psi6 = self.add_bonds(&bonds);
        if self.is_liquid(centers.len()) {
            self.long_range.add_frame(&centers, &psi6);
        }
        self.frames += 1;
    }

    fn add_pairs(&mut self, pairs: &[u64], close: u64, bin_width: f64, count: f64) {
        let all = count * (count - 1.0) / 2.0;
        let within = |r: f64| all * self.pairs_within(r);
        let edge = |bin: usize| within(bin as f64 * bin_width);
        let expected: Vec<f64> = (0..pairs.len()).map(|bin| edge(bin + 1) - edge(bin)).collect();
        let close_at_random =
            within(NEAR_CONTACT_DIAMETERS * self.diameter) - within(self.diameter);
        self.near_contact.add(close as f64 / close_at_random);
        self.correlation.resize(pairs.len(), 0.0);
        for ((sum, found), expected) in self.correlation.iter_mut().zip(pairs).zip(expected) {
            *sum += *found as f64 / expected;
        }
    }

    /// Adds g(r) at contact, extrapolated from the pairs in three shells.
    fn add_shells(&mut self, shells: [u64; SHELL_WEIGHTS.len()], count: f64) {
        let all = count * (count - 1.0) / 2.0;
        let edge = |shell: usize| self.diameter * (1.0 + shell as f64 * SHELL_DIAMETERS);
        let mean = |shell: usize| {
            let expected = self.pairs_within(edge(shell + 1)) - self.pairs_within(edge(shell));
            SHELL_WEIGHTS[shell] * shells[shell] as f64 / (all * expected)
        };
        let extrapolated = mean(0) + mean(1) + mean(2);
        self.at_contact.add(extrapolated);
    }

    /// Adds the order of a frame, and returns psi6 of each disc, which is 0 without neighbors.
    fn add_bonds(&mut self, bonds: &[[f64; 3]]) -> Vec<[f64; 2]> {
        let (mut total, mut local) = ([0.0, 0.0], 0.0);
        let mut psi6 = vec![[0.0, 0.0]; bonds.len()];
        for ([real, imaginary, neighbors], own) in bonds.iter().zip(&mut psi6) {
            if *neighbors == 0.0 {
                continue;
            }
            let psi = [real / neighbors, imaginary / neighbors];
            total = [total[0] + psi[0], total[1] + psi[1]];
            local += libm::hypot(psi[0], psi[1]);
            *own = psi;
        }
        self.psi6_global.add(libm::hypot(total[0], total[1]) / bonds.len() as f64);
        self.psi6_local.add(local / bonds.len() as f64);
        psi6
    }

    /// Whether so many discs fill a periodic box at least as densely as [`MIN_LIQUID_FRACTION`].
    fn is_liquid(&self, discs: usize) -> bool {
        let covered = discs as f64 * PI / 4.0 * self.diameter * self.diameter;
        self.periodic && covered >= MIN_LIQUID_FRACTION * self.region[0] * self.region[1]
    }

    /// Adds the longest waves of the density of a frame.
    pub(super) fn add_waves(&mut self, state: &StateTable) {
        let centers = centers_of(state);
        if self.is_liquid(centers.len()) {
            self.long_range.add_longest_waves(&centers);
        }
    }

    /// Fraction of pairs of random points in the region with a distance below r, for r up to its shorter side: the
    /// integral of 2 pi r (1 - 2 r (a + b)/(pi a b) + r^2/(pi a b)) / (a b) (Philip 2007, distance between points in a
    /// rectangle). In a periodic region: pi r^2/(a b) up to half its shorter side.
    fn pairs_within(&self, r: f64) -> f64 {
        let [a, b] = self.region;
        let area = a * b;
        if self.periodic {
            return PI * r * r / area;
        }
        (PI * area - 4.0 / 3.0 * (a + b) * r + r * r / 2.0) * r * r / (area * area)
    }

    /// Calls `each` for every pair closer than `reach`, using cells of that size. Only cells with discs are stored, so that memory
    /// depends on the number of discs and not on the box.
    fn for_each_pair(
        &self,
        centers: &[[f64; 2]],
        reach: f64,
        mut each: impl FnMut(usize, usize, [f64; 2]),
    ) {
        let cells = [0, 1].map(|axis| ((self.region[axis] / reach) as usize).max(1));
        let place = |center: &[f64; 2], axis: usize| {
            let share = (center[axis] - self.corner[axis]) / self.region[axis];
            // A center outside the region, as in a foreign file, is assigned to the outermost cell: `as` saturates.
            ((share * cells[axis] as f64) as usize).min(cells[axis] - 1)
        };
        // Row, column and index of each disc, in this order.
        let mut members: Vec<[usize; 3]> = centers
            .iter()
            .enumerate()
            .map(|(index, center)| [place(center, 1), place(center, 0), index])
            .collect();
        members.sort_unstable();
        let in_cell = |row: usize, column: usize, after: usize| {
            let start = members.partition_point(|member| *member <= [row, column, after]);
            let own = move |member: &&[usize; 3]| member[..2] == [row, column];
            members[start..].iter().take_while(own).map(|member| member[2])
        };
        for (first, center) in centers.iter().enumerate() {
            let around = |axis: usize| self.cells_around(place(center, axis), cells[axis]);
            let (columns, rows) = (around(0), around(1));
            for row in rows {
                for column in &columns {
                    for second in in_cell(row, *column, first) {
                        let apart = self.apart(center, &centers[second]);
                        if apart[0] * apart[0] + apart[1] * apart[1] < reach * reach {
                            each(first, second, apart);
                        }
                    }
                }
            }
        }
    }

    /// A cell along an axis and its neighbors, each once.
    fn cells_around(&self, own: usize, count: usize) -> Vec<usize> {
        if self.periodic && count > 3 {
            vec![(own + count - 1) % count, own, (own + 1) % count]
        } else if self.periodic {
            (0..count).collect()
        } else {
            (own.saturating_sub(1)..=(own + 1).min(count - 1)).collect()
        }
    }

    /// Vector from one center to another, or to its nearest image.
    fn apart(&self, from: &[f64; 2], to: &[f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let apart = to[axis] - from[axis];
            let side = self.region[axis];
            if self.periodic { apart - side * libm::round(apart / side) } else { apart }
        })
    }

    /// g(r): distance in diameters and mean over the sampled frames.
    pub(crate) fn pair_correlation(&self) -> Vec<(f64, f64)> {
        let middle = |bin: usize| (bin as f64 + 0.5) / BINS_PER_DIAMETER as f64;
        let mean = |sum: &f64| sum / self.frames as f64;
        self.correlation.iter().enumerate().map(|(bin, sum)| (middle(bin), mean(sum))).collect()
    }

    /// g(r) at contact.
    pub(super) fn contact_value(&self) -> Option<Estimate> {
        self.at_contact.estimate()
    }

    /// Mean g(r) between 1 and 1.1 diameters, |mean psi6| and mean |psi6|.
    pub(super) fn estimates(&self) -> Option<[Estimate; 3]> {
        let [near, global, local] =
            [&self.near_contact, &self.psi6_global, &self.psi6_local].map(Blocking::estimate);
        Some([near?, global?, local?])
    }
}

/// The centers of a state; none without positions.
fn centers_of(state: &StateTable) -> Vec<[f64; 2]> {
    let columns = state.column("x").zip(state.column("y"));
    columns.map_or(Vec::new(), |(x, y)| x.zip(y).map(|(x, y)| [x, y]).collect())
}

/// exp(6 i theta) of a unit vector.
fn sixth_power([x, y]: [f64; 2]) -> [f64; 2] {
    let (real, imaginary) = (x * x - y * y, 2.0 * x * y);
    [
        real * (real * real - 3.0 * imaginary * imaginary),
        imaginary * (3.0 * real * real - imaginary * imaginary),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Setup: the formula for random pairs in a rectangle, compared with a fine lattice of points.
    #[test]
    fn pairs_at_random_are_counted_as_in_a_rectangle() {
        let structure = Structure::new(0.5, [5.0, 9.0], false);
        let points: Vec<[f64; 2]> = (0..40 * 80)
            .map(|index| [f64::from(index % 40) * 0.1 + 0.05, f64::from(index / 40) * 0.1 + 0.05])
            .collect();
        let mut near = 0_u64;
        for first in &points {
            near += points
                .iter()
                .filter(|p| libm::hypot(p[0] - first[0], p[1] - first[1]) < 2.0)
                .count() as u64;
        }
        let share = near as f64 / (points.len() * points.len()) as f64;
        assert!((structure.pairs_within(2.0) / share - 1.0).abs() < 0.01, "{share}");
    }

    /// Setup: a square lattice of pitch 1.25 fills a periodic box. Each point has four neighbors at 1, four at sqrt(2)
    /// and four at 2 pitches.
    #[test]
    fn pairs_reach_over_periodic_edges() {
        let structure = Structure::new(0.5, [10.0, 15.0], true);
        let points: Vec<[f64; 2]> = (0..8 * 12)
            .map(|index| [f64::from(index % 8) * 1.25 - 4.9, f64::from(index / 8) * 1.25 - 7.4])
            .collect();
        for reach in [1.3, 1.8, 2.6] {
            let (mut pairs, mut farthest) = (0, 0.0_f64);
            structure.for_each_pair(&points, reach, |_, _, [x, y]| {
                pairs += 1;
                farthest = farthest.max(libm::hypot(x, y));
            });
            let shells = [1.3, 1.8, 2.6].iter().position(|r| *r == reach).unwrap() + 1;
            assert_eq!(pairs, 96 * 4 * shells / 2, "within {reach}");
            assert!(farthest < reach);
        }
    }

    #[test]
    fn a_direction_turned_by_sixty_degrees_is_the_same_bond() {
        let bond = |degrees: f64| {
            sixth_power([libm::cos(degrees.to_radians()), libm::sin(degrees.to_radians())])
        };
        for turned in [0.0, 60.0, 180.0] {
            let [a, b] = [bond(17.0), bond(17.0 + turned)];
            assert!((a[0] - b[0]).abs() < 1e-14 && (a[1] - b[1]).abs() < 1e-14);
        }
        assert!((bond(30.0)[0] + 1.0).abs() < 1e-14);
    }
}
