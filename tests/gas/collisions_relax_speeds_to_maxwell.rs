//! Law: discs that collide elastically forget the law of their speeds for Maxwell's, f(v) = 2 v/<v^2> exp(-v^2/<v^2>), and Boltzmann's
//! H falls to its least value; the points of the same start never do.
//!
//! Source: Boltzmann's H theorem; Maxwell's law in two dimensions. In a fixed energy the shares of N discs are uniform on a simplex, so
//! <v^4>/<v^2>^2 = 2 N/(N + 1) with an error of 2/sqrt(N), and <v>/v_rms = sqrt(pi)/2 with sqrt(1 - pi/4 - pi/16)/sqrt(N) = 0.135/sqrt(N).
//! 2 N times the excess of H, found in 30 bins with one mean square, is a chi-square of 28 degrees of freedom (Wilks 1938).
//! Setup: 2000 discs, R = 1 m, a = 4 mm, v_rms = 1 m/s: 20 s are some 250 collisions a disc.
//! Tolerance: 4.5 standard errors; chi-square below 60, one in three thousand. Control: the same judges refuse the points.

// Tests compare with the platform's functions; what is written in a test is in range.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::runs::{advance, channel, count, gas, max_speed, particles, positive};
use kinetoscope_manifest::model::{GasConfig, SpeedDistribution, SpeedScale};
use kinetoscope_manifest::quantity::NonNegative;
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::model::Target;
use kinetoscope_recording::channels::GasLedger;
use std::f64::consts::PI;

const DISCS: u32 = 2000;

fn start(distribution: SpeedDistribution, disc_radius: Option<f64>) -> GasConfig {
    GasConfig {
        particles: count(DISCS),
        speed_distribution: distribution,
        // <v^2> = 1 for uniform speeds up to sqrt(3).
        speed_scale: max_speed(if distribution == SpeedDistribution::Uniform {
            3.0_f64.sqrt()
        } else {
            1.0
        }),
        disc_radius_m: disc_radius.map(positive),
        duration_s: positive(1000.0),
        ..GasConfig::default()
    }
}

/// <v>/v_rms and <v^4>/<v^2>^2.
fn moments(gas: &Gas) -> [f64; 2] {
    let squares: Vec<f64> = particles(gas)
        .iter()
        .map(|particle| particle.velocity[0].powi(2) + particle.velocity[1].powi(2))
        .collect();
    let mean = |power: f64| {
        squares.iter().map(|square| square.powf(power)).sum::<f64>() / squares.len() as f64
    };
    [mean(0.5) / mean(1.0).sqrt(), mean(2.0) / mean(1.0).powi(2)]
}

/// Whether the speeds are Maxwell's, by all three judges.
fn are_maxwells(gas: &Gas) -> bool {
    let n = f64::from(DISCS);
    let [mean_over_rms, kurtosis] = moments(gas);
    let excess = channel::<GasLedger>(gas).excess_h;
    println!(
        "<v>/v_rms {mean_over_rms}, <v^4>/<v^2>^2 {kurtosis}, 2 N excess of H {}",
        2.0 * n * excess
    );
    let mean_error = (1.0 - PI / 4.0 - PI / 16.0).sqrt() / n.sqrt();
    (mean_over_rms - PI.sqrt() / 2.0).abs() < 4.5 * mean_error
        && (kurtosis - 2.0 * n / (n + 1.0)).abs() < 4.5 * 2.0 / n.sqrt()
        && 2.0 * n * excess < 60.0
}

#[test]
fn discs_take_maxwells_speeds_and_points_do_not() {
    for distribution in [SpeedDistribution::Equal, SpeedDistribution::Uniform] {
        let mut discs = gas(&start(distribution, Some(0.004)), 14);
        assert!(!are_maxwells(&discs));
        advance(&mut discs, Target::Time(20.0));
        assert!(are_maxwells(&discs), "{distribution:?}");
        let mut points = gas(&start(distribution, None), 14);
        let before = channel::<GasLedger>(&points).excess_h;
        advance(&mut points, Target::Time(20.0));
        assert!(!are_maxwells(&points), "{distribution:?}");
        assert!((channel::<GasLedger>(&points).excess_h - before).abs() < 1e-12);
    }
}

/// Law: H never rises but by the scatter of a finite sample, whose standard deviation is sqrt(2 28)/(2 N) = 0.0019.
#[test]
fn h_falls() {
    let mut discs = gas(&start(SpeedDistribution::Equal, Some(0.004)), 15);
    let mut before = channel::<GasLedger>(&discs).excess_h;
    let first = before;
    for step in 1..=20 {
        advance(&mut discs, Target::Time(0.05 * f64::from(step)));
        let now = channel::<GasLedger>(&discs).excess_h;
        assert!(now < before + 4.0 * 0.0019, "from {before} to {now}");
        before = now;
    }
    println!("H above its least: {first} at first, {before} after a dozen collisions a disc");
    assert!(first > 1.0 && before < 0.02);
}

/// Law: a mixture of masses shares its energy alike (equipartition): <m v^2> of each part is the mean of all, with an error of the mean
/// over sqrt(N/2) for parts of N/2 (exponential energies at a fixed total: 1/sqrt(N)). Setup: masses 1 : 4 at equal speeds, so that the
/// heavy ones have 8/5 of the mean at first.
#[test]
fn masses_share_their_energy_alike() {
    let mut config = start(SpeedDistribution::Equal, Some(0.004));
    config.further_masses_kg = vec![positive(4.0 * config.mass_kg.get())];
    let heavy_share = |gas: &Gas| {
        let energies: Vec<f64> = particles(gas)
            .iter()
            .enumerate()
            .map(|(id, particle)| {
                let mass = if id % 2 == 1 { 4.0 } else { 1.0 };
                mass * (particle.velocity[0].powi(2) + particle.velocity[1].powi(2))
            })
            .collect();
        let heavy: f64 = energies.iter().skip(1).step_by(2).sum();
        2.0 * heavy / energies.iter().sum::<f64>()
    };
    let mut discs = gas(&config, 16);
    assert!((heavy_share(&discs) - 1.6).abs() < 1e-12);
    advance(&mut discs, Target::Time(30.0));
    println!("energy of the heavy half over the mean: {}", heavy_share(&discs));
    assert!((heavy_share(&discs) - 1.0).abs() < 4.5 / f64::from(DISCS).sqrt());
}

/// Promise: written speeds are given to the particles in turn, as they are or brought to a temperature.
#[test]
fn written_speeds_are_kept() {
    let speeds = [1.0, 2.0, 0.0].map(|speed| NonNegative::new(speed).unwrap());
    let mut config = GasConfig {
        particles: count(7),
        speeds_m_per_s: speeds.to_vec(),
        speed_scale: SpeedScale::Given,
        ..GasConfig::default()
    };
    let found = |config: &GasConfig| -> Vec<f64> {
        particles(&gas(config, 1)).iter().map(|particle| particle.speed()).collect()
    };
    for (found, wanted) in found(&config).iter().zip([1.0, 2.0, 0.0, 1.0, 2.0, 0.0, 1.0]) {
        assert!((found - wanted).abs() < 1e-15);
    }
    config.speed_scale = crate::runs::kelvin(300.0);
    let scaled = found(&config);
    assert!((scaled[1] / scaled[0] - 2.0).abs() < 1e-14 && scaled[2] == 0.0);
}
