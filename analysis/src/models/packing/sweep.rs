//! Plots of packing runs along an axis of a sweep.

use crate::models::contract::Ordinate;

/// Metrics that are plotted against swept numbers.
pub(super) const ORDINATES: &[Ordinate] = &[
    Ordinate::new("pair_collision_rate_per_disc", "collision rate per disc"),
    Ordinate::new("compressibility_factor", "compressibility factor"),
    Ordinate::new("pressure.reduced", "P d²/kT"),
    Ordinate::new("a2.mean", "mean a₂"),
    Ordinate::new("temperature.final_over_initial", "T / T at the start"),
];
