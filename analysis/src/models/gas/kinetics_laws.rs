//! Laws of a gas with collisions, and of stationary and non-stationary starts.

use crate::metric::Law;
use kinetoscope_manifest::model::{GasConfig, PositionDistribution};
use std::f64::consts::PI;

/// Relaxation to Maxwell's distribution, by the first moment.
pub const MAXWELL_MEAN: Law = Law {
    statement: "<v>/v_rms = sqrt(pi)/2 after many collisions",
    source: "Maxwell's law in two dimensions",
};
/// Relaxation to Maxwell's distribution, by the fourth moment.
pub const MAXWELL_A2: Law = Law {
    statement: "a2 = -1/(N + 1) after many collisions",
    source: "Maxwell's law in two dimensions, N discs of a fixed energy",
};
/// Minimum of Boltzmann's H.
pub const LEAST_H: Law = Law {
    statement: "H = -ln(pi e <v^2>), and (bins - 2)/(2N) more for a histogram of N discs",
    source: "Boltzmann's H of Maxwell's law in two dimensions; scatter by Wilks 1938",
};
/// Pair collision rate.
pub const ENSKOG_RATE: Law = Law {
    statement: "2 sqrt(pi) n s sqrt(<v^2>/2) (1 - 7c/16)/(1 - c)^2 per disc, less the pairs that the wall leaves out",
    source: "Enskog 1922, Henderson 1975; disc line picking",
};
/// Compressibility factor.
pub const HENDERSON: Law = Law {
    statement: "Z = (1 + c^2/8)/(1 - c)^2, Z - 1 less the pairs that the wall leaves out",
    source: "Henderson 1975; disc line picking",
};
/// Pressure from the virial.
pub const CLAUSIUS: Law = Law {
    statement: "P = (N m <v^2> + W/t) / (2 pi R (R - a)), W the virial of the pairs, a the disc's radius",
    source: "Clausius 1870",
};
/// Stationary start.
pub const STATIONARY: Law =
    Law { statement: "1: uniform over the area is stationary", source: "Liouville's theorem" };
/// Fraction of particles within half the radius.
pub const SHARE_INSIDE: Law = Law {
    statement: "1/4 at all times if uniform over the area; if uniform in the radius 1/2 at first and 0.32807 later",
    source: "areas; time on a chord within r/2, averaged by quadrature",
};

/// Fraction within half the radius after a long time, for a start uniform in the radius. With d = U sin(phi), U and phi
/// uniform, it is the mean of sqrt(1/4 - d^2)/sqrt(1 - d^2) over d < 1/2.
const SHARE_OF_RADIUS_START: f64 = 0.328_072_88;

/// Fraction of the particles within half the radius at the start.
#[must_use]
pub const fn share_inside_at_start(places: PositionDistribution) -> f64 {
    match places {
        PositionDistribution::UniformInArea => 0.25,
        PositionDistribution::UniformInRadius => 0.5,
    }
}

/// Fraction of the particles within half the radius after a long time.
#[must_use]
pub const fn share_inside_later(places: PositionDistribution) -> f64 {
    match places {
        PositionDistribution::UniformInArea => 0.25,
        PositionDistribution::UniformInRadius => SHARE_OF_RADIUS_START,
    }
}

/// H of Maxwell's distribution, -ln(pi e `<v^2>`), velocities in m/s.
#[must_use]
pub fn least_h(mean_square_m2_per_s2: f64) -> f64 {
    -(PI * mean_square_m2_per_s2).ln() - 1.0
}

/// Equilibrium of colliding discs with equal masses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collisions {
    /// Collisions per disc and second.
    pub rate_per_s: f64,
    /// P A / (N k_B T).
    pub compressibility_factor: f64,
}

/// Kinetic theory of discs at this mean square speed; `None` for points.
#[must_use]
pub fn collisions(config: &GasConfig, mean_square_m2_per_s2: f64) -> Option<Collisions> {
    let disc_radius = config.disc_radius_m?.get();
    let (diameter, reach) = (2.0 * disc_radius, config.radius_m.get() - disc_radius);
    let others = f64::from(config.particles.get()) - 1.0;
    let density = others / (PI * reach * reach);
    let covered = density * PI * disc_radius * disc_radius;
    // Pairs at this distance in the circle, divided by those in an infinite plane.
    let x = diameter / (2.0 * reach);
    let in_reach = 2.0 / PI * (x.acos() - x * (1.0 - x * x).sqrt());
    let contact = (1.0 - 7.0 * covered / 16.0) / ((1.0 - covered) * (1.0 - covered));
    let thermal = (mean_square_m2_per_s2 / 2.0).sqrt();
    Some(Collisions {
        rate_per_s: 2.0 * PI.sqrt() * density * diameter * thermal * contact * in_reach,
        // Z - 1 = 2 c X.
        compressibility_factor: 1.0 + 2.0 * covered * contact * in_reach,
    })
}
