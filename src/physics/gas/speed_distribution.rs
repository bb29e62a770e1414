//! Histogram of the speeds, with the initial distribution and the Maxwell distribution.

use kinetoscope_recording::channels::GasSpeeds;
use serde::{Deserialize, Serialize};

/// Number of bins of the histogram.
const BINS: usize = 30;

/// Upper end of the histogram over the rms speed for the Maxwell distribution: 0.2 % of the speeds are above.
const MAXWELL_TOP_OVER_RMS: f64 = 2.5;

/// Upper end over the rms speed for a single speed or an unknown distribution: a single speed is then in the middle of bin 12. At 2.5, it
/// would be on the edge of a bin, and rounding would distribute it over two bins.
const SINGLE_SPEED_TOP_OVER_RMS: f64 = 2.4;

/// Upper end if all particles are at rest, m/s: a range must have a width.
const TOP_AT_REST: f64 = 1.0;

/// Distribution of the speeds at the start, after rescaling.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum InitialSpeeds {
    /// Uniform in [0, max).
    Uniform {
        /// Upper bound, m/s.
        max_speed: f64,
    },
    /// Maxwell distribution in two dimensions.
    Maxwell {
        /// `<v^2>` of the distribution, m^2/s^2; that of the sample differs.
        mean_square: f64,
    },
    /// One speed for all particles.
    Equal,
    /// Given in the manifest or in a recording.
    Given,
}

impl InitialSpeeds {
    /// Probability density at a speed, s/m; 0 for a single speed or an unknown distribution.
    #[must_use]
    pub fn density(&self, speed: f64) -> f64 {
        match *self {
            Self::Uniform { max_speed } if speed < max_speed => 1.0 / max_speed,
            Self::Maxwell { mean_square } => maxwell_density(speed, mean_square),
            Self::Uniform { .. } | Self::Equal | Self::Given => 0.0,
        }
    }

    /// Upper end of the displayed speeds, m/s: positive and fixed for the run. If particles collide, it has room for the Maxwell
    /// distribution.
    #[must_use]
    pub fn range_top(&self, rms_speed_at_start: f64, has_collisions: bool) -> f64 {
        let top = match *self {
            Self::Uniform { max_speed } if !has_collisions => max_speed,
            Self::Maxwell { .. } | Self::Uniform { .. } => {
                MAXWELL_TOP_OVER_RMS * rms_speed_at_start
            }
            Self::Equal | Self::Given => SINGLE_SPEED_TOP_OVER_RMS * rms_speed_at_start,
        };
        if top > 0.0 { top } else { TOP_AT_REST }
    }
}

/// Maxwell distribution of the speeds in two dimensions, f(v) = 2 v / `<v^2>` exp(-v^2 / `<v^2>`), s/m; 0 for a gas at rest.
#[must_use]
pub fn maxwell_density(speed: f64, mean_square: f64) -> f64 {
    if mean_square > 0.0 {
        2.0 * speed / mean_square * libm::exp(-speed * speed / mean_square)
    } else {
        0.0
    }
}

/// Histogram with 30 equal bins in [0, `range_top`). Densities refer to all particles; a speed beyond the range is in no bin, so the sum
/// over the bins is the fraction inside. The Maxwell distribution is that of the given mean square.
#[must_use]
pub fn histogram(
    speeds: impl Iterator<Item = f64>,
    initial: InitialSpeeds,
    range_top: f64,
    mean_square: f64,
) -> GasSpeeds {
    let width = range_top / BINS as f64;
    let mut particles = 0.0;
    let mut counts = [0_u64; BINS];
    for speed in speeds {
        particles += 1.0;
        if let Some(count) = counts.get_mut((speed / width) as usize) {
            *count += 1;
        }
    }
    let rms = mean_square.sqrt();
    // A gas at rest has no scale: its scaled axis is 0.
    let per_rms = if rms > 0.0 { 1.0 / rms } else { 0.0 };
    let scaled = |values: &[f64], factor: f64| values.iter().map(|value| value * factor).collect();
    let centers: Vec<f64> = (0..BINS).map(|bin| (bin as f64 + 0.5) * width).collect();
    let density: Vec<f64> =
        counts.iter().map(|&count| count as f64 / (particles * width)).collect();
    let initial_distribution: Vec<f64> =
        centers.iter().map(|&speed| initial.density(speed)).collect();
    let maxwell: Vec<f64> =
        centers.iter().map(|&speed| maxwell_density(speed, mean_square)).collect();
    GasSpeeds {
        speed_over_rms: scaled(&centers, per_rms),
        density_times_rms: scaled(&density, rms),
        initial_distribution_times_rms: scaled(&initial_distribution, rms),
        maxwell_times_rms: scaled(&maxwell, rms),
        speed_m_per_s: centers,
        density,
        initial_distribution,
        maxwell,
    }
}
