//! Law: discs of several diameters s and one mass, without walls: with the contact values
//!
//! g_ij = 1/(1 - f) + (9/16) f/(1 - f)^2 (s_i s_j/s_ij) <s>/<s^2>, s_ij = (s_i + s_j)/2,
//!
//! - the pressure is Z - 1 = 2 f <s_ij^2 g_ij>/<s^2>, means over all pairs;
//! - a disc collides 2 sqrt(pi) n <s_ij g_ij> sqrt(kT/m) times a unit of time;
//! - so that virial and rate agree: Z - 1 = (sqrt(pi)/4) w sqrt(m/kT) <s_ij^2 g_ij>/<s_ij g_ij>.
//!
//! Source: Santos, Yuste and Lopez de Haro, Mol. Phys. 96, 1 (1999), with Henderson's g of one size, (1 - 7f/16)/(1 - f)^2, which the
//! form becomes there; Enskog's rate.
//! Setup: 500 discs, radii uniform within 80 % of 1, at f of about 0.12 and 0.36, after 300 collisions a disc; sums over all pairs of
//! the radii that were drawn.
//! Tolerance: 4 standard errors of blocks, and 1 % of Z - 1 and of the rate: 0.4 % that 500 discs are short of many, and the form's own error,
//! a few in a thousand. Virial and rate share their collisions: 4 errors and 0.3 %.
//! Controls: Henderson's pressure of one size, and the mean diameter in the identity, are both rejected.

// A test judges within tolerances: no bit of a run depends on it.
#![allow(clippy::disallowed_methods, missing_docs)]

use crate::periodic_states::{excess_and_rate, periodic};
use crate::runs::{at_fraction, look, prepare};
use kinetoscope_manifest::model::PackingConfig;
use kinetoscope_manifest::quantity::NonNegative;
use std::f64::consts::PI;

/// What the contact values say of drawn radii in a box: f, <s>, <s_ij g_ij>, <s_ij^2 g_ij> and <s^2>.
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
                let middle = (one + other) / 2.0;
                let crowding = 9.0 / 16.0 * fraction / (free * free) * mean / square;
                let contact = 1.0 / free + crowding * one * other / middle;
                first += middle * contact;
                second += middle * middle * contact;
            }
        }
        let pairs = count * count;
        Self { fraction, mean, first: first / pairs, second: second / pairs, square }
    }
}

#[test]
fn pressure_and_rate_of_a_mixture_are_those_of_its_contact_values() {
    for fraction in [0.1, 0.3] {
        let mixed = PackingConfig {
            polydispersity: NonNegative::literal(0.8),
            ..periodic(at_fraction(500, fraction))
        };
        let radii: Vec<f64> =
            look(&prepare(&mixed, 17, 0)).iter().map(|disc| disc.radius).collect();
        let area = mixed.width.get() * mixed.height.get();
        let theory = Mixture::of(&radii, area);
        let f = theory.fraction;
        let ([excess, excess_error], [rate, rate_error]) = excess_and_rate(&mixed, 60);

        let expected = 2.0 * f * theory.second / theory.square;
        let expected_rate = 2.0 * PI.sqrt() * radii.len() as f64 / area * theory.first;
        let by_rate = |diameter: f64| PI.sqrt() / 4.0 * diameter * rate;
        let diameter = theory.second / theory.first;
        let of_one_size = (1.0 + f * f / 8.0) / ((1.0 - f) * (1.0 - f)) - 1.0;
        println!(
            "f {f:.4}: Z - 1 {excess:.4} +- {excess_error:.4}, theory {expected:.4}, of one size {of_one_size:.4}, by the rate {:.4}; \
             rate {rate:.5} +- {rate_error:.5}, theory {expected_rate:.5}; diameter of collisions {diameter:.4}, mean {:.4}",
            by_rate(diameter),
            theory.mean
        );
        let is_near = |value: f64| (excess - value).abs() < 4.0 * excess_error + 0.01 * excess;
        assert!(is_near(expected));
        assert!(!is_near(of_one_size), "control");
        assert!((rate - expected_rate).abs() < 4.0 * rate_error + 0.01 * rate);
        let agree = |value: f64| (excess - value).abs() < 4.0 * excess_error + 0.003 * excess;
        assert!(agree(by_rate(diameter)));
        assert!(!agree(by_rate(theory.mean)), "control");
    }
}

/// Of one size the form is Henderson's.
#[test]
fn one_size_is_hendersons() {
    let theory = Mixture::of(&[0.7; 20], 100.0);
    let f = theory.fraction;
    let henderson = (1.0 - 7.0 * f / 16.0) / ((1.0 - f) * (1.0 - f));
    assert!((theory.first / 1.4 / henderson - 1.0).abs() < 1e-14);
    assert!((theory.second / theory.square / henderson - 1.0).abs() < 1e-14);
}
