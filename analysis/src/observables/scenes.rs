//! What is seen of DEM scenes with a law of their own: an outlet, a heap, a gas that cools, a row of discs.

use super::{Series, StateTable};
use crate::statistics::{least_squares_line, mean};
use kinetoscope_manifest::model::{DemConfig, DemWall, DemWallShape, PeriodicSides, Placement};

/// Discs that have left, over time.
#[derive(Clone, Debug, Default)]
pub(super) struct Outflow {
    removed: Series<(f64, u64)>,
}

/// The part of the discharge whose rate is taken, as shares of the discs that have left at the end: the first ones fall before
/// the flow is steady, the last ones have no bed above them.
const STEADY_SHARE: [f64; 2] = [0.1, 0.6];

impl Outflow {
    pub(super) fn see(&mut self, time: f64, removed: u64) {
        self.removed.add((time, removed));
    }

    /// Discs a second, by the line through the counts of the steady part.
    pub(super) fn rate_per_s(&self) -> Option<f64> {
        let most = self.removed.last()?.1 as f64;
        let [low, high] = STEADY_SHARE.map(|share| share * most);
        let steady = self.removed.iter().map(|&(time, removed)| (time, removed as f64));
        let steady: Vec<(f64, f64)> =
            steady.filter(|(_, removed)| (low..=high).contains(removed) && most > 0.0).collect();
        if steady.len() < 3 { None } else { least_squares_line(&steady).map(|line| line.slope) }
    }
}

/// Width of the one opening between two level walls at one height, m.
pub(crate) fn opening_width_m(config: &DemConfig) -> Option<f64> {
    let resting = config.walls.iter().filter(|wall| wall.is_at_rest());
    let mut level: Vec<(f64, [f64; 2])> = resting
        .filter_map(|wall| match wall.shape {
            DemWallShape::Segment { from_m, to_m } if from_m[1] == to_m[1] => {
                let ends = [from_m[0].get(), to_m[0].get()];
                Some((from_m[1].get(), [ends[0].min(ends[1]), ends[0].max(ends[1])]))
            }
            _ => None,
        })
        .collect();
    level.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    match level.as_slice() {
        [(height, left), (other, right)] if height == other && right[0] > left[1] => {
            Some(right[0] - left[1])
        }
        _ => None,
    }
}

/// The number of the first level wall that moves, among the box's walls and the manifest's.
pub(super) fn piston(config: &DemConfig) -> Option<usize> {
    let of_box = match config.periodic {
        PeriodicSides::None => 4,
        PeriodicSides::X | PeriodicSides::Y => 2,
        PeriodicSides::Both => 0,
    };
    let moves_level = |wall: &DemWall| match wall.shape {
        DemWallShape::Segment { from_m, to_m } => {
            let moves = |axis: usize| {
                let velocity = wall.velocity_m_per_s[axis].get();
                velocity != 0.0 || wall.amplitude_m[axis].get() != 0.0
            };
            from_m[1] == to_m[1] && moves(1) && !moves(0)
        }
        DemWallShape::Drum { .. } => false,
    };
    config.walls.iter().position(moves_level).map(|number| of_box + number)
}

/// Whether an upright wall moves away to its side for a time.
pub(super) fn has_gate(config: &DemConfig) -> bool {
    config.walls.iter().any(|wall| match wall.shape {
        DemWallShape::Segment { from_m, to_m } => {
            from_m[0] == to_m[0] && wall.velocity_m_per_s[0].get() != 0.0 && wall.moves_s.is_some()
        }
        DemWallShape::Drum { .. } => false,
    })
}

/// Mean of a series over the last tenth of its time.
pub(super) fn late_mean(series: &Series<(f64, f64)>) -> Option<f64> {
    let (&(begin, _), &(end, _)) = (series.first()?, series.last()?);
    let since = end - 0.1 * (end - begin);
    let late: Vec<f64> =
        series.iter().filter(|(time, _)| *time > since).map(|&(_, value)| value).collect();
    mean(&late)
}

/// Granular temperature over time, of discs that nothing heats.
#[derive(Clone, Debug, Default)]
pub(super) struct Cooling {
    temperature: Series<(f64, f64)>,
}

impl Cooling {
    pub(super) fn see(&mut self, time: f64, temperature: f64) {
        self.temperature.add((time, temperature));
    }

    /// The temperature at the start, m^2/s^2.
    pub(super) fn first(&self) -> Option<f64> {
        self.temperature.first().map(|&(_, temperature)| temperature)
    }

    /// 1/tau of T = T0 / (1 + t/tau)^2, 1/s: the slope of sqrt(T0/T) - 1 over t, by least squares through the origin.
    pub(super) fn rate_per_s(&self) -> Option<f64> {
        let &(begin, first) = self.temperature.first()?;
        let (mut products, mut squares) = (0.0, 0.0);
        for &(time, temperature) in self.temperature.iter() {
            let since = time - begin;
            products += since * ((first / temperature).sqrt() - 1.0);
            squares += since * since;
        }
        (squares > 0.0 && first > 0.0).then(|| products / squares)
    }
}

/// Whether discs cool by themselves: no walls, no gravity.
pub(crate) fn is_free_gas(config: &DemConfig) -> bool {
    let falls = config.gravity_m_per_s2.iter().any(|component| component.get() != 0.0);
    config.periodic == PeriodicSides::Both && !falls && config.walls.is_empty()
}

/// The number of discs of a row whose first disc alone moves at the start, along x; `None` of any other start.
pub(crate) fn row_of(config: &DemConfig) -> Option<usize> {
    let Placement::Given(state) = &config.placement else { return None };
    let falls = config.gravity_m_per_s2.iter().any(|component| component.get() != 0.0);
    let (first, others) = state.velocities.split_first()?;
    let rest = others.iter().flatten().all(|component| component.get() == 0.0);
    let level = state.positions.iter().all(|place| place[1] == state.positions[0][1]);
    let moves = first[0].get() > 0.0 && first[1].get() == 0.0;
    (!falls && rest && level && moves && !others.is_empty()).then_some(state.positions.len())
}

/// Velocity of a row's last disc over that of its first at the start.
pub(super) fn transmitted_velocity(config: &DemConfig, end: &StateTable) -> Option<f64> {
    let count = row_of(config)?;
    let Placement::Given(state) = &config.placement else { return None };
    Some(end.value(count - 1, "vx")? / state.velocities[0][0].get())
}

/// The upper surface of discs (x, y, radius): the highest point over each column of two mean diameters from the left-hand
/// wall on, `None` over empty ones.
fn surface(discs: &[[f64; 4]], width: f64) -> (f64, Vec<Option<f64>>) {
    let mean = discs.iter().map(|disc| disc[2]).sum::<f64>() / discs.len() as f64;
    let columns = (width / (4.0 * mean)).floor().max(1.0);
    let pitch = width / columns;
    let mut tops: Vec<Option<f64>> = vec![None; columns as usize];
    for &[x, y, radius, _] in discs {
        let column = ((x / pitch).max(0.0) as usize).min(tops.len() - 1);
        let top = tops[column].get_or_insert(0.0);
        *top = top.max(y + radius);
    }
    (pitch, tops)
}

/// How far from the left-hand wall discs stand without a gap as wide as a column of two diameters, m.
pub(super) fn reach_m(discs: &[[f64; 4]], width: f64) -> Option<f64> {
    let (pitch, tops) = surface(discs, width);
    let columns = tops.iter().position(Option::is_none).unwrap_or(tops.len());
    let edge = columns as f64 * pitch;
    let ends = discs.iter().filter(|disc| disc[0] < edge).map(|disc| disc[0] + disc[2]);
    (columns > 0).then(|| ends.fold(0.0, f64::max))
}

/// Shares of a heap's height between which its slope is taken: its foot and its tip are round.
const FLANK: [f64; 2] = [0.15, 0.85];

/// The mean slope of a heap's two flanks, degrees: least squares of the surface's height over the distance from the heap's
/// middle, which is its discs' mean place.
pub(super) fn slope_deg(discs: &[[f64; 4]], width: f64) -> Option<f64> {
    let (pitch, tops) = surface(discs, width);
    let areas = discs.iter().map(|disc| disc[2] * disc[2]).sum::<f64>();
    let middle = discs.iter().map(|disc| disc[0] * disc[2] * disc[2]).sum::<f64>() / areas;
    let floor = discs.iter().map(|disc| disc[1] - disc[2]).fold(f64::INFINITY, f64::min);
    let height = tops.iter().flatten().fold(0.0_f64, |top, &at| top.max(at)) - floor;
    let [low, high] = FLANK.map(|share| floor + share * height);
    let columns = tops.iter().enumerate();
    let flanks: Vec<(f64, f64)> = columns
        .filter_map(|(column, top)| Some((((column as f64 + 0.5) * pitch - middle).abs(), (*top)?)))
        .filter(|(_, top)| (low..=high).contains(top))
        .collect();
    if flanks.len() < 4 {
        return None;
    }
    least_squares_line(&flanks).map(|line| (-line.slope).atan().to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle of discs with a slope of 1 : 2, row by row on a lattice of 1 mm: its slope is 26.57 degrees.
    #[test]
    fn the_slope_of_a_triangle_is_its_own() {
        let mut discs = Vec::new();
        for row in 0..30 {
            let half = 2 * (30 - row);
            for column in -half..=half {
                let x = 0.1 + 1e-3 * f64::from(column);
                discs.push([x, 1e-3 * (f64::from(row) + 0.5), 5e-4, 1.0]);
            }
        }
        let slope = slope_deg(&discs, 0.2).unwrap();
        assert!((slope - 26.57).abs() < 1.5, "{slope}");
        // One disc far off does not belong to it.
        let level: Vec<[f64; 4]> =
            (0..20).map(|column| [1e-3 * (f64::from(column) + 0.5), 5e-4, 5e-4, 1.0]).collect();
        let stray = [0.15, 5e-4, 5e-4, 1.0];
        let reach = reach_m(&[&level[..], &[stray]].concat(), 0.2).unwrap();
        assert!((reach - 0.02).abs() < 1e-12, "{reach}");
    }

    /// Counts of a steady stream between a slow beginning and a slow end.
    #[test]
    fn the_rate_is_that_of_the_steady_part() {
        let mut outflow = Outflow::default();
        for frame in 0..=100 {
            let time = 0.01 * f64::from(frame);
            let removed = if time < 0.1 { 0.0 } else { 1000.0 * (time - 0.1) };
            outflow.see(time, if removed < 800.0 { removed.round() as u64 } else { 800 });
        }
        let rate = outflow.rate_per_s().unwrap();
        assert!((rate - 1000.0).abs() < 1.0, "{rate}");
        assert!(Outflow::default().rate_per_s().is_none());
    }

    #[test]
    fn the_rate_of_haffs_law_is_found() {
        let mut cooling = Cooling::default();
        for frame in 0..50 {
            let time = 0.02 * f64::from(frame);
            cooling.see(time, 4e-3 / ((1.0 + 3.0 * time) * (1.0 + 3.0 * time)));
        }
        assert!((cooling.rate_per_s().unwrap() - 3.0).abs() < 1e-12);
    }
}
