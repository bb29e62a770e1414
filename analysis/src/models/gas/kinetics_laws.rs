//! Laws of a gas with collisions, and of stationary and non-stationary starts.

use crate::metric::law::laws;
use crate::metric::theory::ExpectedValue;
use crate::metric::{Quantity, Violation};
use crate::models::hard_discs::{
    Container, DiscSizes, MAX_BULK_FRACTION, confined_accuracy, fixed_energy_speed,
};
use kinetoscope_manifest::model::{GasConfig, PositionDistribution};
use std::f64::consts::PI;

laws! {
    MAXWELL_MEAN: "<v>/v_rms = sqrt(pi)/2 (1 + 1/(8N) + 1/(128 N^2)) after many collisions", "Maxwell's law in two dimensions, N discs of a fixed energy", range "after 40 collisions per disc";
    MAXWELL_A2: "a2 = -1/(N + 1) after many collisions", "Maxwell's law in two dimensions, N discs of a fixed energy", range "after 40 collisions per disc";
    MIN_H: "H = -ln(pi <v^2>) - 1, and about (bins - 2)/(2N) more for a histogram of N discs, by Poisson's distribution where few are expected", "Boltzmann's H of Maxwell's law in two dimensions; scatter by Wilks 1938", range "after 40 collisions per disc";
    ENSKOG_RATE: "ν = 4 (Z - 1) sqrt(<v^2>/2) / (sqrt(pi) d), times the mean speed at fixed energy over Maxwell's", "Enskog 1922 and the virial theorem; Kolafa and Rottner 2006; wall by Helfand, Frisch and Lebowitz 1961", range "φ up to 0.6 far from the wall; accuracy (0.3 + (10 + 6000 φ^6)/N) %", named "Enskog's theory";
    CONFINED_DISCS: "Z by Kolafa and Rottner, with the line tension of scaled-particle theory at the wall, corrected for fixed N", "Kolafa and Rottner 2006; wall by Helfand, Frisch and Lebowitz 1961", range "φ up to 0.6 far from the wall; accuracy (0.3 + (10 + 6000 φ^6)/N) % of Z - 1";
    CLAUSIUS: "P = (N m <v^2> + W/t) / (2 pi R (R - d/2))", "Clausius 1870";
    STATIONARY: "1: uniform over the area is stationary", "Liouville's theorem";
    FRACTION_WITHIN: "1/4 at all times if uniform over the area; if uniform in the radius 1/2 at first and 0.32807 later", "areas; time on a chord within R/2, averaged by quadrature", range "points; 0.32807 after 20 crossings";
}

/// Fraction within half the radius after a long time, for a start uniform in the radius. With d = U sin(phi), U and phi
/// uniform, it is the mean of sqrt(1/4 - d^2)/sqrt(1 - d^2) over d < 1/2.
const LATE_FRACTION_OF_UNIFORM_RADIUS: f64 = 0.328_072_88;

/// Fraction of the particles within half the radius at the start.
pub(crate) const fn fraction_within_at_start(places: PositionDistribution) -> f64 {
    match places {
        PositionDistribution::UniformInArea | PositionDistribution::Barometric => 0.25,
        PositionDistribution::UniformInRadius => 0.5,
    }
}

/// Fraction of the particles within half the radius after a long time.
pub(crate) const fn fraction_within_later(places: PositionDistribution) -> f64 {
    match places {
        PositionDistribution::UniformInArea | PositionDistribution::Barometric => 0.25,
        PositionDistribution::UniformInRadius => LATE_FRACTION_OF_UNIFORM_RADIUS,
    }
}

/// H of Maxwell's distribution, -ln(pi e `<v^2>`), velocities in m/s.
pub(crate) fn min_h(mean_square_m2_per_s2: f64) -> f64 {
    -libm::log(PI * mean_square_m2_per_s2) - 1.0
}

/// Equilibrium of colliding discs with equal masses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Collisions {
    /// Collisions per disc and second.
    pub(crate) rate_per_s: f64,
    /// P A / (N k_B T).
    pub(crate) compressibility_factor: f64,
    /// Accuracy of Z - 1 and of the rate, as a fraction of them.
    relative_accuracy: f64,
    violation: Option<Violation>,
}

impl Collisions {
    /// The collision rate with its accuracy.
    pub(crate) fn rate(&self) -> ExpectedValue {
        let accuracy = Some(self.relative_accuracy * self.rate_per_s);
        ExpectedValue { value: self.rate_per_s, accuracy, violation: self.violation }
    }

    /// The compressibility factor with its accuracy.
    pub(crate) fn compressibility(&self) -> ExpectedValue {
        let value = self.compressibility_factor;
        let accuracy = Some(self.relative_accuracy * (value - 1.0));
        ExpectedValue { value, accuracy, violation: self.violation }
    }
}

/// Equilibrium of discs at this mean square speed; `None` for points, and where the fluid has no theory.
///
/// Specular reflection in a circle conserves the angular momentum. Its energy is kT/2 on average over starts and scatters by
/// 0.7 kT, so the thermal energy of one run is uncertain by the fraction 0.7/N; the error of the measured values contains this.
pub(crate) fn collisions(config: &GasConfig, mean_square_m2_per_s2: f64) -> Option<Collisions> {
    let disc_radius = config.disc_radius_m?.get();
    let discs = f64::from(config.particles.get());
    let container = Container::Circle { radius: config.radius_m.get() };
    let ratio = disc_radius / config.radius_m.get();
    let sizes = DiscSizes::equal(discs * ratio * ratio, disc_radius);
    let fluid = container.filled(discs, sizes)?;
    let (excess, fraction) = (fluid.excess(discs), fluid.bulk.packing_fraction);
    if !(excess > 0.0 && excess.is_finite()) {
        return None;
    }
    let thermal = (mean_square_m2_per_s2 / 2.0).sqrt() * fixed_energy_speed(discs);
    Some(Collisions {
        rate_per_s: excess * 4.0 * thermal / (PI.sqrt() * 2.0 * disc_radius),
        compressibility_factor: 1.0 + excess,
        relative_accuracy: confined_accuracy(fraction, discs),
        violation: Quantity::PackingFraction.at_most(fraction, MAX_BULK_FRACTION),
    })
}

/// Mean and standard deviation of the relative entropy of a histogram of particles that follow Maxwell's distribution with the measured
/// mean square.
///
/// The sum over the bins of n ln(n/e) - n + e, with Poisson numbers n that have the expectations e, tends to half of
/// chi-square for large e (Wilks 1938) and is smaller for small e. The number of particles and their mean square are given,
/// which takes away two of chi-square's degrees of freedom.
pub(crate) fn relative_entropy_moments(expected: &[f64], particles: f64) -> Option<[f64; 2]> {
    const CONSTRAINTS: f64 = 2.0;
    let (mut mean, mut variance) = (-CONSTRAINTS / 2.0, -CONSTRAINTS / 2.0);
    for &expected in expected.iter().filter(|expected| **expected > 0.0) {
        let [of_bin, square] = poisson_divergence_moments(expected);
        mean += of_bin;
        variance += square - of_bin * of_bin;
    }
    (mean > 0.0 && variance > 0.0).then(|| [mean / particles, variance.sqrt() / particles])
}

/// Mean and mean square of n ln(n/e) - n + e for a Poisson number n with the expectation e.
fn poisson_divergence_moments(expected: f64) -> [f64; 2] {
    if expected > MOST_SUMMED {
        // From the central moments of the Poisson distribution; the next terms are of order 1/expected^2.
        return [0.5 + 1.0 / (12.0 * expected), 0.75 + 0.25 / expected];
    }
    // Terms beyond ten standard deviations are below 1e-20.
    let reach = 10.0 * expected.sqrt() + 20.0;
    let first = (expected - reach).max(0.0).floor() as u64;
    let last = (expected + reach).ceil() as u64;
    let (mut moments, mut total) = ([0.0; 2], 0.0);
    let mut logarithm = -expected + first as f64 * libm::log(expected) - ln_factorial(first);
    for count in first..=last {
        let count = count as f64;
        let (probability, ratio) = (libm::exp(logarithm), count / expected);
        let divergence =
            if count > 0.0 { count * libm::log(ratio) - count + expected } else { expected };
        moments[0] += probability * divergence;
        moments[1] += probability * divergence * divergence;
        total += probability;
        logarithm += libm::log(expected / (count + 1.0));
    }
    moments.map(|moment| moment / total)
}

/// Expected number up to which the moments are summed: a manifest may claim any number of particles.
const MOST_SUMMED: f64 = 1e6;

fn ln_factorial(number: u64) -> f64 {
    (2..=number).map(|factor| libm::log(factor as f64)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinetoscope_manifest::quantity::Positive;

    /// Guarantee: many particles take no more time than few, and the moments continue beyond the largest sum. Reference: the sum itself.
    #[test]
    fn divergence_of_many_particles_continues_the_sum() {
        let [summed, expanded] =
            [MOST_SUMMED, MOST_SUMMED * (1.0 + 1e-15)].map(poisson_divergence_moments);
        for (summed, expanded) in summed.into_iter().zip(expanded) {
            assert!((summed - expanded).abs() < 1e-9, "{summed} and {expanded}");
        }
        assert!(poisson_divergence_moments(1e300).into_iter().all(f64::is_finite));
    }

    /// Source: event-driven runs of 4 replicates each, and for 0.405 and N = 100 two independent programs: packing fraction
    /// N (a/R)^2, Z and its standard error.
    /// Control: the theory of a fluid without walls deviates by more than the allowed difference.
    #[test]
    fn discs_in_a_circle_agree_with_simulation() {
        for (discs, fraction, simulated, error) in [
            (200, 0.1, 1.239_04, 3e-4),
            (200, 0.2, 1.579_46, 9e-4),
            (200, 0.3, 2.084_2, 2.5e-3),
            (200, 0.405, 2.925, 3e-3),
            (200, 0.5, 4.201, 5e-3),
            (100, 0.25, 1.815_4, 5e-4),
        ] {
            let config = GasConfig {
                particles: u32::try_from(discs).unwrap().try_into().unwrap(),
                radius_m: Positive::new(1.0).unwrap(),
                disc_radius_m: Positive::new((fraction / f64::from(discs)).sqrt()),
                ..GasConfig::default()
            };
            let theory = collisions(&config, 2.0).unwrap().compressibility();
            let allowed = 3.0 * libm::hypot(error, theory.accuracy.unwrap());
            let z = theory.value;
            println!("{discs} {fraction}: {z} {simulated} {allowed}");
            assert!((z - simulated).abs() < allowed, "{discs} {fraction}: {z} {simulated}");
            let bulk = DiscSizes::equal(fraction, 1.0).compressibility();
            assert!((bulk - simulated).abs() > 0.5 * allowed, "{discs} {fraction}: {bulk}");
        }
    }
}
