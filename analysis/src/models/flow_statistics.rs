//! Test for homogeneity of a gas of dissipative discs: whether neighbors move together or gather.
//!
//! The laws of the homogeneous cooling state hold as long as velocities of neighbors are independent. Later, vortices hold a
//! growing part of the energy, and discs gather in clusters (Goldhirsch and Zanetti, Phys. Rev. Lett. 70 (1993) 1619; Brito and
//! Ernst, Europhys. Lett. 43 (1998) 497).

use crate::metric::{Quantity, Violation};
use kinetoscope_recording::reader::StateTable;

/// Mean number of discs per cell.
const DISCS_PER_CELL: f64 = 8.0;
/// Minimum number of cells per side, that of 128 discs: with fewer, a flow of the whole box is hardly distinguished from chance.
const MIN_CELLS_PER_SIDE: f64 = 4.0;
/// Excess over 1 above which neighbors move together or gather, times the cells per side. For independent velocities, the ratio
/// of one state scatters by 1 over the cells per side, and for independent positions by sqrt(2) over it. Discs in equilibrium
/// are spread more evenly than independent points.
const MAX_EXCESS: f64 = 3.0;

/// Two ratios of square cells, averaged over states: the energy of their mean velocities over that for independent velocities,
/// and the variance of their numbers of discs over that for independent positions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FlowStatistics {
    flow: f64,
    clustering: f64,
    states: f64,
    cells_per_side: f64,
    lacks_states: bool,
}

impl FlowStatistics {
    /// Adds a frame of which the recording has no state.
    pub(crate) fn add_frame_without_state(&mut self) {
        self.lacks_states = true;
    }

    /// Adds a state of discs in a rectangle with this lower left corner.
    pub(crate) fn add_state(&mut self, state: &StateTable, corner: [f64; 2], sides: [f64; 2]) {
        self.cells_per_side = (state.rows() as f64 / DISCS_PER_CELL).sqrt().floor();
        if self.cells_per_side < MIN_CELLS_PER_SIDE {
            return;
        }
        let columns = ["x", "y", "vx", "vy"].map(|name| state.index(name));
        let [Some(x), Some(y), Some(vx), Some(vy)] = columns else { return };
        let discs = (0..state.rows()).map(|disc| {
            let row = state.row(disc);
            let place = [(row[x] - corner[0]) / sides[0], (row[y] - corner[1]) / sides[1]];
            (place, [row[vx], row[vy]])
        });
        self.add_discs(discs);
    }

    /// Adds a state of discs, each with its place as fractions of the sides and its velocity.
    fn add_discs(&mut self, discs: impl Iterator<Item = ([f64; 2], [f64; 2])>) {
        if let Some([flow, clustering]) = ratios(discs, self.cells_per_side as usize) {
            self.flow += flow;
            self.clustering += clustering;
            self.states += 1.0;
        }
    }

    /// The violation, unless neighbors moved independently and were spread evenly, in states of at least 128 discs.
    pub(crate) fn violation(&self) -> Option<Violation> {
        let greatest = self.flow.max(self.clustering) / self.states;
        let largest = MAX_EXCESS / self.cells_per_side;
        (Quantity::StateOfManyDiscs.required(self.states > 0.0))
            .or_else(|| Quantity::FlowBetweenKeyframes.required(!self.lacks_states))
            .or_else(|| Quantity::FlowOrClusters.at_most(greatest - 1.0, largest))
    }
}

/// Sum over cells of n V^2, over its mean for independent velocities, `<v^2>` times the number of occupied cells less one; and
/// sum over cells of (n - `<n>`)^2 over its mean for independent positions, `<n>` times the number of cells less one.
fn ratios(
    discs: impl Iterator<Item = ([f64; 2], [f64; 2])>,
    cells_per_side: usize,
) -> Option<[f64; 2]> {
    let mut cells = vec![(0.0, [0.0; 2]); cells_per_side * cells_per_side];
    let (mut total, mut squares, mut number) = ([0.0; 2], 0.0, 0.0);
    for (place, velocity) in discs {
        let [column, line] = place
            .map(|part| ((part * cells_per_side as f64).max(0.0) as usize).min(cells_per_side - 1));
        let cell = &mut cells[line * cells_per_side + column];
        cell.0 += 1.0;
        number += 1.0;
        for (axis, velocity) in velocity.into_iter().enumerate() {
            cell.1[axis] += velocity;
            total[axis] += velocity;
            squares += velocity * velocity;
        }
    }
    let drift = total.map(|sum| sum / number);
    let thermal = squares / number - drift[0] * drift[0] - drift[1] * drift[1];
    let occupied = cells.iter().filter(|(count, _)| *count > 0.0);
    let (energy, count) = occupied.fold((0.0, 0.0), |(energy, cells), (count, sum)| {
        let flow = [sum[0] - count * drift[0], sum[1] - count * drift[1]];
        (energy + (flow[0] * flow[0] + flow[1] * flow[1]) / count, cells + 1.0)
    });
    let (all, mean) = (cells.len() as f64, number / cells.len() as f64);
    let spread: f64 = cells.iter().map(|(count, _)| (count - mean) * (count - mean)).sum();
    let has_flow = thermal > 0.0 && count > 1.0;
    has_flow.then(|| [energy / (thermal * (count - 1.0)), spread / (mean * (all - 1.0))])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Uniform;
    use std::f64::consts::TAU;

    /// Whether 20 states of discs at random, whose places and velocities a function changes, are homogeneous.
    fn homogeneity(
        discs: u32,
        change: impl Fn([f64; 2], [f64; 2]) -> ([f64; 2], [f64; 2]),
    ) -> bool {
        let mut uniform = Uniform(83);
        let cells_per_side = (f64::from(discs) / DISCS_PER_CELL).sqrt().floor();
        let mut statistics = FlowStatistics { cells_per_side, ..FlowStatistics::default() };
        for _ in 0..20 {
            let discs: Vec<_> = (0..discs)
                .map(|_| {
                    let place = [uniform.next(), uniform.next()];
                    change(place, [uniform.normal(), uniform.normal()])
                })
                .collect();
            statistics.add_discs(discs.into_iter());
        }
        statistics.violation().is_none()
    }

    /// Guarantee: vortices and clusters are found, in 128 discs and more. Setup: a shear flow with half of the energy, and half
    /// of the discs in a third of the box. Control: independent discs, and all of them drifting, are homogeneous.
    #[test]
    fn shear_and_clusters_are_not_homogeneous() {
        for discs in [128, 500] {
            assert!(homogeneity(discs, |place, velocity| (place, velocity)));
            let drift = |place, [vx, vy]: [f64; 2]| (place, [vx + 5.0, vy]);
            assert!(homogeneity(discs, drift));
            let shear = |place: [f64; 2], [vx, vy]: [f64; 2]| {
                (place, [vx + 2.0 * libm::sin(TAU * place[1]), vy])
            };
            assert!(!homogeneity(discs, shear));
            let cluster = |[x, y]: [f64; 2], velocity| {
                (if y < 0.5 { [x / 3.0, y] } else { [x, y] }, velocity)
            };
            assert!(!homogeneity(discs, cluster));
        }
    }
}
