//! Laws of a gas with collisions, and of stationary and non-stationary starts.

use crate::metric::law::laws;
use kinetoscope_manifest::model::{GasConfig, PositionDistribution};
use std::f64::consts::PI;

laws! {
    MAXWELL_MEAN: "<v>/v_rms = sqrt(pi)/2 after many collisions", "Maxwell's law in two dimensions";
    MAXWELL_A2: "a2 = -1/(N + 1) after many collisions", "Maxwell's law in two dimensions, N discs of a fixed energy";
    MIN_H: "H = -ln(pi <v^2>) - 1, and (bins - 2)/(2N) more for a histogram of N discs", "Boltzmann's H of Maxwell's law in two dimensions; scatter by Wilks 1938";
    ENSKOG_RATE: "ν = 2 sqrt(pi) n d sqrt(<v^2>/2) (1 - 7φ/16)/(1 - φ)^2, less the pairs that the wall leaves out", "Enskog 1922, Henderson 1975; disc line picking";
    HENDERSON: "Z = (1 + φ^2/8)/(1 - φ)^2, Z - 1 less the pairs that the wall leaves out", "Henderson 1975; disc line picking";
    CLAUSIUS: "P = (N m <v^2> + W/t) / (2 pi R (R - d/2))", "Clausius 1870";
    STATIONARY: "1: uniform over the area is stationary", "Liouville's theorem";
    FRACTION_WITHIN: "1/4 at all times if uniform over the area; if uniform in the radius 1/2 at first and 0.32807 later", "areas; time on a chord within R/2, averaged by quadrature";
}

/// Fraction within half the radius after a long time, for a start uniform in the radius. With d = U sin(phi), U and phi
/// uniform, it is the mean of sqrt(1/4 - d^2)/sqrt(1 - d^2) over d < 1/2.
const LATE_FRACTION_OF_UNIFORM_RADIUS: f64 = 0.328_072_88;

/// Fraction of the particles within half the radius at the start.
pub(crate) const fn fraction_within_at_start(places: PositionDistribution) -> f64 {
    match places {
        PositionDistribution::UniformInArea => 0.25,
        PositionDistribution::UniformInRadius => 0.5,
    }
}

/// Fraction of the particles within half the radius after a long time.
pub(crate) const fn fraction_within_later(places: PositionDistribution) -> f64 {
    match places {
        PositionDistribution::UniformInArea => 0.25,
        PositionDistribution::UniformInRadius => LATE_FRACTION_OF_UNIFORM_RADIUS,
    }
}

/// H of Maxwell's distribution, -ln(pi e `<v^2>`), velocities in m/s.
pub(crate) fn min_h(mean_square_m2_per_s2: f64) -> f64 {
    -(PI * mean_square_m2_per_s2).ln() - 1.0
}

/// Equilibrium of colliding discs with equal masses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Collisions {
    /// Collisions per disc and second.
    pub(crate) rate_per_s: f64,
    /// P A / (N k_B T).
    pub(crate) compressibility_factor: f64,
}

/// Kinetic theory of discs at this mean square speed; `None` for points.
pub(crate) fn collisions(config: &GasConfig, mean_square_m2_per_s2: f64) -> Option<Collisions> {
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
