//! Law: the speeds follow the distribution from which they were drawn, uniform or Maxwell's f(v) = 2 v/<v^2>
//! exp(-v^2/<v^2>).
//!
//! Source: gas exercise 14g1 (uniform speeds and directions); Maxwell's distribution in two dimensions.
//! Setup: 100,000 particles in the initial state; the 30 bins of the channel.
//! Tolerance: chi-square of the 30 bins below 59.7, which is exceeded with a probability of 1/1000 at 30 degrees of freedom.
//! Control: uniform speeds are rejected for Maxwell's distribution.

// Tests compare with the platform's functions and do not affect recorded bits.
#![allow(clippy::disallowed_methods)]

use crate::runs::{advance, channel, count, gas, particles};
use kinetoscope_manifest::model::{GasConfig, SpeedDistribution};
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_recording::channels::GasSpeeds;
use std::f64::consts::TAU;

const PARTICLES: f64 = 100_000.0;

fn drawn(speed_distribution: SpeedDistribution) -> GasConfig {
    GasConfig { particles: count(100_000), speed_distribution, ..GasConfig::default() }
}

/// Chi-square of the counts for a density at the centers of the bins.
fn chi_square(speeds: &GasSpeeds, distribution: &[f64]) -> f64 {
    let width = speeds.speed_m_per_s[1] - speeds.speed_m_per_s[0];
    let terms = speeds.density.iter().zip(distribution).map(|(measured, expected)| {
        let (found, expected) = (measured * width * PARTICLES, expected * width * PARTICLES);
        (found - expected) * (found - expected) / expected
    });
    terms.sum()
}

#[test]
fn drawn_speeds_follow_their_distribution() {
    let uniform = channel::<GasSpeeds>(&gas(&drawn(SpeedDistribution::Uniform), 14));
    let found = chi_square(&uniform, &uniform.initial_distribution);
    let control = chi_square(&uniform, &uniform.maxwell);
    println!("uniform: {found}, for Maxwell's distribution {control}");
    assert!(found < 59.7);
    assert!(control > 59.7);
    // Maxwell's distribution is curved within a bin: its center differs by f'' w^2 / 24, below 1e-3 of f, and
    // chi-square by less than 1.
    let maxwell = channel::<GasSpeeds>(&gas(&drawn(SpeedDistribution::Maxwell), 14));
    for distribution in [&maxwell.initial_distribution, &maxwell.maxwell] {
        let found = chi_square(&maxwell, distribution);
        println!("Maxwell: {found}");
        assert!(found < 59.7 + 1.0);
    }
    let width = maxwell.speed_m_per_s[1] - maxwell.speed_m_per_s[0];
    let inside: f64 = maxwell.density.iter().sum::<f64>() * width;
    // The range ends at 2.5 v_rms, and the fraction exp(-6.25) = 0.00193 is beyond it.
    assert!((1.0 - inside - 0.00193).abs() < 4.0 * (0.00193 / PARTICLES).sqrt());
    let equal = channel::<GasSpeeds>(&gas(&drawn(SpeedDistribution::Equal), 14));
    assert_eq!(equal.density.iter().filter(|&&density| density > 0.0).count(), 1);
    assert!(equal.initial_distribution.iter().all(|&density| density == 0.0));
}

#[test]
fn directions_are_uniform() {
    for speed_distribution in
        [SpeedDistribution::Uniform, SpeedDistribution::Maxwell, SpeedDistribution::Equal]
    {
        let mut counts = [0.0_f64; 30];
        for particle in particles(&gas(&drawn(speed_distribution), 14)) {
            let angle = particle.velocity[1].atan2(particle.velocity[0]).rem_euclid(TAU);
            counts[((angle / TAU * 30.0) as usize).min(29)] += 1.0;
        }
        let expected = PARTICLES / 30.0;
        let found: f64 =
            counts.iter().map(|count| (count - expected) * (count - expected) / expected).sum();
        println!("{speed_distribution:?}: {found}");
        assert!(found < 59.7);
    }
}

#[test]
fn bins_are_constant_in_time() {
    let mut gas = gas(&GasConfig::default(), 1);
    let before = channel::<GasSpeeds>(&gas);
    let top = gas.scenery().speed_range_top;
    for (bin, center) in before.speed_m_per_s.iter().enumerate() {
        assert!((center - (bin as f64 + 0.5) * top / 30.0).abs() < 1e-12 * top);
    }
    advance(&mut gas, Target::Time(0.05));
    let after = channel::<GasSpeeds>(&gas);
    assert_eq!(before.speed_m_per_s, after.speed_m_per_s);
    assert_eq!(before.initial_distribution, after.initial_distribution);
}
