//! Test for homogeneity of a gas of dissipative discs: whether neighbors move together.
//!
//! The laws of the homogeneous cooling state hold as long as velocities of neighbors are independent. Later, vortices hold a
//! growing part of the energy (Goldhirsch and Zanetti, Phys. Rev. Lett. 70 (1993) 1619; Brito and Ernst, Europhys. Lett. 43
//! (1998) 497).

use kinetoscope_recording::reader::StateTable;

/// Mean number of discs per cell.
const DISCS_PER_CELL: f64 = 8.0;
/// Excess over 1 above which neighbors move together, times the cells per side. For independent velocities, the ratio of one
/// state scatters by 1 over the cells per side.
const MAX_EXCESS: f64 = 3.0;

/// Energy of the mean velocities of square cells over that for independent velocities, averaged over states.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FlowStatistics {
    sum: f64,
    states: f64,
    cells_per_side: f64,
}

impl FlowStatistics {
    /// Adds a state of discs in a rectangle with this lower left corner.
    pub(crate) fn add_state(&mut self, state: &StateTable, corner: [f64; 2], sides: [f64; 2]) {
        let cells_per_side = (state.rows() as f64 / DISCS_PER_CELL).sqrt().floor();
        self.cells_per_side = cells_per_side;
        self.states += 1.0;
        if cells_per_side >= 2.0
            && let Some(ratio) = flow_energy_ratio(state, corner, sides, cells_per_side as usize)
        {
            self.sum += ratio;
        } else {
            self.sum += 1.0;
        }
    }

    /// Whether the velocities of neighbors were independent; `None` without a state.
    pub(crate) fn is_homogeneous(&self) -> Option<bool> {
        let excess = self.sum / self.states - 1.0;
        (self.states > 0.0).then(|| excess <= MAX_EXCESS / self.cells_per_side.max(1.0))
    }
}

/// Sum over cells of n V^2, over its mean for independent velocities, `<v^2>` times the number of occupied cells less one.
fn flow_energy_ratio(
    state: &StateTable,
    corner: [f64; 2],
    sides: [f64; 2],
    cells_per_side: usize,
) -> Option<f64> {
    let columns = ["x", "y", "vx", "vy"].map(|name| state.index(name));
    let [Some(x), Some(y), Some(vx), Some(vy)] = columns else { return None };
    let mut cells = vec![(0.0, [0.0; 2]); cells_per_side * cells_per_side];
    let (mut total, mut squares) = ([0.0; 2], 0.0);
    for disc in 0..state.rows() {
        let row = state.row(disc);
        let place = [(row[x] - corner[0]) / sides[0], (row[y] - corner[1]) / sides[1]];
        let [column, line] = place
            .map(|part| ((part * cells_per_side as f64).max(0.0) as usize).min(cells_per_side - 1));
        let cell = &mut cells[line * cells_per_side + column];
        cell.0 += 1.0;
        for (axis, velocity) in [row[vx], row[vy]].into_iter().enumerate() {
            cell.1[axis] += velocity;
            total[axis] += velocity;
            squares += velocity * velocity;
        }
    }
    let discs = state.rows() as f64;
    let drift = total.map(|sum| sum / discs);
    let thermal = squares / discs - drift[0] * drift[0] - drift[1] * drift[1];
    let occupied = cells.iter().filter(|(count, _)| *count > 0.0);
    let (energy, count) = occupied.fold((0.0, 0.0), |(energy, cells), (count, sum)| {
        let flow = [sum[0] - count * drift[0], sum[1] - count * drift[1]];
        (energy + (flow[0] * flow[0] + flow[1] * flow[1]) / count, cells + 1.0)
    });
    (thermal > 0.0 && count > 1.0).then(|| energy / (thermal * (count - 1.0)))
}
