//! Walls and starts with a special role, found in the manifest: outlets, pistons, gates, rows of discs.

use crate::models::series::Series;
use crate::statistics::mean;
use kinetoscope_manifest::model::{DemConfig, DemWall, DemWallShape, PeriodicSides, Placement};
use kinetoscope_recording::reader::StateTable;

/// Width of the only opening between two horizontal walls at the same height, m.
pub(crate) fn orifice_width_m(config: &DemConfig) -> Option<f64> {
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

/// Index of the first moving horizontal wall among the walls of the box and of the manifest.
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

/// Whether a vertical wall moves sideways for a limited time.
pub(super) fn has_gate(config: &DemConfig) -> bool {
    config.walls.iter().any(|wall| match wall.shape {
        DemWallShape::Segment { from_m, to_m } => {
            from_m[0] == to_m[0] && wall.velocity_m_per_s[0].get() != 0.0 && wall.moves_s.is_some()
        }
        DemWallShape::Drum { .. } => false,
    })
}

/// Number of discs in a row of which only the first moves at the start, along x; `None` for any other start.
pub(crate) fn row_of(config: &DemConfig) -> Option<usize> {
    let Placement::Given(state) = &config.placement else { return None };
    let falls = config.gravity_m_per_s2.iter().any(|component| component.get() != 0.0);
    let (first, others) = state.velocities_m_per_s.split_first()?;
    let rest = others.iter().flatten().all(|component| component.get() == 0.0);
    let level = state.positions_m.iter().all(|place| place[1] == state.positions_m[0][1]);
    let moves = first[0].get() > 0.0 && first[1].get() == 0.0;
    (!falls && rest && level && moves && !others.is_empty()).then_some(state.positions_m.len())
}

/// Velocity of a row's last disc at the end, divided by that of its first disc at the start.
pub(super) fn velocity_transmission(config: &DemConfig, end: &StateTable) -> Option<f64> {
    let count = row_of(config)?;
    let Placement::Given(state) = &config.placement else { return None };
    Some(end.value(count - 1, "vx")? / state.velocities_m_per_s[0][0].get())
}

/// Mean of a series over the last tenth of its time.
pub(super) fn late_mean(series: &Series<(f64, f64)>) -> Option<f64> {
    let (&(begin, _), &(end, _)) = (series.first()?, series.last()?);
    let since = end - 0.1 * (end - begin);
    let late: Vec<f64> =
        series.iter().filter(|(time, _)| *time > since).map(|&(_, value)| value).collect();
    mean(&late)
}
