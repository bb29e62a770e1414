//! What follows from the recorded state of one frame.

use crate::statistics::mean;
use kinetoscope_manifest::model::GasConfig;
use kinetoscope_recording::reader::StateTable;

/// Moments of the speeds at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpeedMeans {
    pub(super) mean_m_per_s: f64,
    pub(super) mean_square_m2_per_s2: f64,
    /// |`<v>`|, m/s.
    pub(super) drift_m_per_s: f64,
}

/// Speed moments of a state; `None` without velocities.
pub(super) fn speeds_of(state: &StateTable) -> Option<SpeedMeans> {
    let (vx, vy): (Vec<f64>, Vec<f64>) =
        (state.column("vx")?.collect(), state.column("vy")?.collect());
    let squares: Vec<f64> = vx.iter().zip(&vy).map(|(x, y)| x * x + y * y).collect();
    let lengths: Vec<f64> = squares.iter().map(|square| square.sqrt()).collect();
    Some(SpeedMeans {
        mean_m_per_s: mean(&lengths)?,
        mean_square_m2_per_s2: mean(&squares)?,
        drift_m_per_s: libm::hypot(mean(&vx)?, mean(&vy)?),
    })
}

/// Squared speed of each particle; `None` without velocities.
pub(super) fn squares_of(state: &StateTable) -> Option<Vec<f64>> {
    Some(state.column("vx")?.zip(state.column("vy")?).map(|(x, y)| x * x + y * y).collect())
}

/// Wall collision rate (1/s) and speed (m/s) of each particle at the start.
pub(super) type OwnRates = Vec<[f64; 2]>;

/// Wall collision rate of each particle: its speed over its chord 2 sqrt(R^2 - d^2), d its distance of closest
/// approach.
pub(super) fn own_rates(state: &StateTable, config: &GasConfig) -> OwnRates {
    let places = ["x", "y", "vx", "vy"].map(|name| state.index(name));
    let [Some(x), Some(y), Some(vx), Some(vy)] = places else { return Vec::new() };
    let [center_x, center_y] = config.center_m.map(|component| component.get());
    let radius = config.radius_m.get();
    (0..state.rows())
        .map(|particle| {
            let row = state.row(particle);
            let moment = (row[x] - center_x) * row[vy] - (row[y] - center_y) * row[vx];
            let square = row[vx] * row[vx] + row[vy] * row[vy];
            let chord = 2.0 * (radius * radius - moment * moment / square).sqrt();
            if square > 0.0 { [square.sqrt() / chord, square.sqrt()] } else { [0.0; 2] }
        })
        .collect()
}

/// Fraction of the particles within half the radius; `None` without positions, or if the container changes its size or
/// loses particles.
pub(super) fn fraction_within_half_radius(state: &StateTable, config: &GasConfig) -> Option<f64> {
    if config.wall_speed_m_per_s.get() != 0.0 || config.orifice_width_m.is_some() {
        return None;
    }
    let [cx, cy] = config.center_m.map(|component| component.get());
    let half = config.radius_m.get() / 2.0;
    let inside = state
        .column("x")?
        .zip(state.column("y")?)
        .filter(|(x, y)| (x - cx) * (x - cx) + (y - cy) * (y - cy) < half * half)
        .count();
    Some(inside as f64 / state.rows() as f64)
}
