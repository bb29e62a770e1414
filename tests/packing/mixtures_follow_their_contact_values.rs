//! Law: discs of several diameters s and one mass, in a periodic box at packing fraction f, have
//!
//! - the pressure Z - 1 = 2 f <s_ij^2 g_ij>/<s^2>, means over all pairs;
//! - the collision rate per disc 2 sqrt(pi) n <s_ij g_ij> sqrt(kT/m);
//! - the identity Z - 1 = (sqrt(pi)/4) w sqrt(m/kT) <s_ij^2 g_ij>/<s_ij g_ij> between virial and rate w;
//!
//! with the contact values g_ij = 1/(1 - f) + (9/16) f/(1 - f)^2 (s_i s_j/s_ij) <s>/<s^2> and s_ij = (s_i + s_j)/2.
//!
//! Source: Santos, Yuste and Lopez de Haro, Mol. Phys. 96 (1999) 1, which reduces to Henderson's g = (1 - 7f/16)/(1 -
//! f)^2 for one size; Enskog's rate.
//! Setup: 500 discs, radii uniform within 80 % of 1, at f of about 0.12 and 0.36, after 300 collisions per disc; sums
//! over all pairs of the radii drawn.
//! Tolerance: 4 standard errors of blocks, and 1 % of Z - 1 and of the rate: 0.4 % for 500 discs instead of many, and a
//! few per mille for the approximation of g_ij. Virial and rate share their collisions: 4 standard errors and 0.3 %.
//! Control: Henderson's pressure of one size, and the mean diameter in the identity, are rejected.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods, missing_docs)]

use crate::periodic_states::{excess_and_rate, periodic};
use crate::runs::{at_fraction, disc_states, prepare};
use kinetoscope_manifest::model::PackingConfig;
use kinetoscope_manifest::quantity::NonNegative;
use std::f64::consts::PI;

/// Averages over the radii drawn: f, <s>, <s_ij g_ij>, <s_ij^2 g_ij> and <s^2>.
struct Mixture {
    fraction: f64,
    mean: f64,
    first: f64,
    second: f64,
    square: f64,
}

impl Mixture {
    fn of(radii: &[f64], area: f64) -> Self {
        let count = radii.len() as f64;
        let diameters: Vec<f64> = radii.iter().map(|radius| 2.0 * radius).collect();
        let mean = diameters.iter().sum::<f64>() / count;
        let square = diameters.iter().map(|s| s * s).sum::<f64>() / count;
        let fraction = count * PI / 4.0 * square / area;
        let free = 1.0 - fraction;
        let (mut first, mut second) = (0.0, 0.0);
        for one in &diameters {
            for other in &diameters {
                let mean_diameter = (one + other) / 2.0;
                let excess = 9.0 / 16.0 * fraction / (free * free) * mean / square;
                let contact = 1.0 / free + excess * one * other / mean_diameter;
                first += mean_diameter * contact;
                second += mean_diameter * mean_diameter * contact;
            }
        }
        let pairs = count * count;
        Self { fraction, mean, first: first / pairs, second: second / pairs, square }
    }
}

#[test]
fn pressure_and_rate_of_a_mixture_follow_its_contact_values() {
    for fraction in [0.1, 0.3] {
        let mixed = PackingConfig {
            radius_half_width: NonNegative::literal(0.8),
            ..periodic(at_fraction(500, fraction))
        };
        let radii: Vec<f64> =
            disc_states(&prepare(&mixed, 17, 0)).iter().map(|disc| disc.radius).collect();
        let area = mixed.width.get() * mixed.height.get();
        let theory = Mixture::of(&radii, area);
        let f = theory.fraction;
        let ([excess, excess_error], [rate, rate_error]) = excess_and_rate(&mixed, 60);

        let expected = 2.0 * f * theory.second / theory.square;
        let expected_rate = 2.0 * PI.sqrt() * radii.len() as f64 / area * theory.first;
        let from_rate = |diameter: f64| PI.sqrt() / 4.0 * diameter * rate;
        let diameter = theory.second / theory.first;
        let one_size = (1.0 + f * f / 8.0) / ((1.0 - f) * (1.0 - f)) - 1.0;
        println!(
            "f {f:.4}: Z - 1 {excess:.4} +- {excess_error:.4}, theory {expected:.4}, one size {one_size:.4}, from the rate {:.4}; \
             rate {rate:.5} +- {rate_error:.5}, theory {expected_rate:.5}; collision diameter {diameter:.4}, mean {:.4}",
            from_rate(diameter),
            theory.mean
        );
        let is_near = |value: f64| (excess - value).abs() < 4.0 * excess_error + 0.01 * excess;
        assert!(is_near(expected));
        assert!(!is_near(one_size), "control");
        assert!((rate - expected_rate).abs() < 4.0 * rate_error + 0.01 * rate);
        let agree = |value: f64| (excess - value).abs() < 4.0 * excess_error + 0.003 * excess;
        assert!(agree(from_rate(diameter)));
        assert!(!agree(from_rate(theory.mean)), "control");
    }
}

/// Tolerance: 1e-14, the rounding of the sums.
#[test]
fn contact_value_of_one_size_is_hendersons() {
    let theory = Mixture::of(&[0.7; 20], 100.0);
    let f = theory.fraction;
    let henderson = (1.0 - 7.0 * f / 16.0) / ((1.0 - f) * (1.0 - f));
    assert!((theory.first / 1.4 / henderson - 1.0).abs() < 1e-14);
    assert!((theory.second / theory.square / henderson - 1.0).abs() < 1e-14);
}
