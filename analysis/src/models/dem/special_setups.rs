//! Special setups, found in the manifest: outlets, pistons, gates, rows of discs and free gases.

use crate::models::series::Series;
use crate::statistics::{Blocking, Entries, Estimate, MissingError, least_squares_line, mean};
use kinetoscope_manifest::model::{DemConfig, DemWall, DemWallShape, PeriodicSides, Placement};
use kinetoscope_recording::reader::StateTable;

/// Width of the only opening between two horizontal walls at the same height, m.
pub(super) fn orifice_width_m(config: &DemConfig) -> Option<f64> {
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
pub(super) fn row_of(config: &DemConfig) -> Option<usize> {
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

/// Whether the box supports the discs from below.
pub(super) fn has_floor(config: &DemConfig) -> bool {
    !matches!(config.periodic, PeriodicSides::Y | PeriodicSides::Both)
}

/// Whether any contact is frictional.
pub(super) fn has_friction(config: &DemConfig) -> bool {
    let of_materials = config.materials.iter().filter_map(|material| material.constants.friction);
    let of_pairs = config.contact_pairs.iter().filter_map(|pair| pair.constants.friction);
    let mut all = of_materials.chain(of_pairs).chain([config.friction]);
    all.any(|friction| friction.get() > 0.0)
}

/// Whether discs cool freely: no walls and no gravity.
pub(super) fn is_free_gas(config: &DemConfig) -> bool {
    let falls = config.gravity_m_per_s2.iter().any(|component| component.get() != 0.0);
    config.periodic == PeriodicSides::Both && !falls && config.walls.is_empty()
}

/// 1/tau of T = T0 / (1 + t/tau)^2, 1/s: the slope of sqrt(T0/T) - 1 over t, by least squares through the origin.
pub(super) fn cooling_rate_per_s(temperature: &Series<(f64, f64)>) -> Option<f64> {
    let &(begin, first) = temperature.first()?;
    let (mut products, mut squares) = (0.0, 0.0);
    for &(time, temperature) in temperature.iter() {
        let since = time - begin;
        products += since * ((first / temperature).sqrt() - 1.0);
        squares += since * since;
    }
    (squares > 0.0 && first > 0.0).then(|| products / squares)
}

/// Fractions of all removed discs between which the discharge rate is measured: the first discs fall before the flow is
/// steady, and the last ones have no bed above them.
const STEADY_FRACTIONS: [f64; 2] = [0.1, 0.6];

/// Variance of the slope of a least-squares line through a random walk, over that of the slope between its ends.
const SLOPE_OVER_ENDS_VARIANCE: f64 = 1.2;

/// The part of the numbers of removed discs in which the flow is steady.
pub(super) fn steady_part(removed: &Series<(f64, f64)>) -> Vec<(f64, f64)> {
    let all = removed.last().map_or(0.0, |(_, all)| *all);
    let [low, high] = STEADY_FRACTIONS.map(|fraction| fraction * all);
    let steady = removed.iter().filter(|(_, count)| (low..=high).contains(count) && all > 0.0);
    steady.copied().collect()
}

/// Discs per second, by a line through the numbers of removed discs in the steady part. Its error follows by blocking from the numbers
/// between frames: they add up to a random walk, of which a line through all points has 6/5 of the variance of one through the ends.
pub(super) fn discharge_rate_per_s(removed: &Series<(f64, f64)>) -> Option<Estimate> {
    let steady = steady_part(removed);
    let line = if steady.len() < 3 { None } else { least_squares_line(&steady) }?;
    let mut blocks = Blocking::of(Entries::Intervals);
    for pair in steady.windows(2) {
        blocks.add_amount(pair[1].1 - pair[0].1, pair[1].0 - pair[0].0);
    }
    let of_ends = blocks.estimate()?;
    let error = of_ends.standard_error.map(|error| error * SLOPE_OVER_ENDS_VARIANCE.sqrt());
    Some(Estimate { value: line.slope, standard_error: error, ..of_ends })
}

/// Mean of a series over the last tenth of its time. It has no error, because beds at rest differ from seed to seed.
pub(super) fn late_mean(series: &Series<(f64, f64)>) -> Option<Estimate> {
    let (&(begin, _), &(end, _)) = (series.first()?, series.last()?);
    let since = end - 0.1 * (end - begin);
    let late: Vec<f64> =
        series.iter().filter(|(time, _)| *time > since).map(|&(_, value)| value).collect();
    mean(&late).map(|mean| Estimate::bare(mean).without_error(MissingError::DependsOnStart))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Uniform;
    use crate::statistics::standard_deviation;

    fn series(entry: impl Fn(f64) -> f64) -> Series<(f64, f64)> {
        let mut series = Series::default();
        for frame in 0..=100 {
            let time = 0.01 * f64::from(frame);
            series.add((time, entry(time)));
        }
        series
    }

    #[test]
    fn cooling_rate_is_that_of_haffs_law() {
        let temperature = series(|time| 4e-3 / ((1.0 + 3.0 * time) * (1.0 + 3.0 * time)));
        assert!((cooling_rate_per_s(&temperature).unwrap() - 3.0).abs() < 1e-12);
    }

    /// Setup: a steady stream between a slow beginning and a slow end.
    #[test]
    fn discharge_rate_is_that_of_the_steady_part() {
        let removed = series(|time| libm::round((1000.0 * (time - 0.1)).clamp(0.0, 800.0)));
        let rate = discharge_rate_per_s(&removed).unwrap();
        assert!((rate.value - 1000.0).abs() < 1.0, "{rate:?}");
        // 100 frames have too few intervals in half of the stream.
        assert!(rate.standard_error.is_none() && rate.missing_error.is_some());
        assert!(discharge_rate_per_s(&Series::default()).is_none());
    }

    /// Setup: discs leave independently of each other; the scatter of the rate over 400 streams is compared with the stated error.
    /// Tolerance: a standard deviation of 400 values is uncertain by 3.5 %, an error of 15 blocks by 20 %.
    #[test]
    fn error_of_the_discharge_rate_is_the_scatter_between_streams() {
        let (mut rates, mut errors) = (Vec::new(), Vec::new());
        let mut uniform = Uniform(11);
        for _ in 0..400 {
            let (mut removed, mut count) = (Series::default(), 0.0);
            for frame in 0..=500 {
                removed.add((0.01 * f64::from(frame), count));
                count += (0..20).filter(|_| uniform.next() < 0.3).count() as f64;
            }
            let rate = discharge_rate_per_s(&removed).unwrap();
            rates.push(rate.value);
            errors.push(rate.standard_error.unwrap());
        }
        let ratio = standard_deviation(&rates).unwrap() / mean(&errors).unwrap();
        assert!((0.9..1.15).contains(&ratio), "{ratio}");
    }
}
