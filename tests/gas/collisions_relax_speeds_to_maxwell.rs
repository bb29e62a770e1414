//! Law: elastic collisions relax any distribution of speeds to Maxwell's, f(v) = 2 v/<v^2> exp(-v^2/<v^2>), and
//! Boltzmann's H falls to its minimum; points of the same initial state never relax.
//!
//! Source: Boltzmann's H theorem; Maxwell's distribution in two dimensions. At fixed energy, the energy fractions of N
//! discs are uniform on a simplex, so <v^4>/<v^2>^2 = 2 N/(N + 1) with standard error 2/sqrt(N), and <v>/v_rms =
//! sqrt(pi)/2 with sqrt(1 - pi/4 - pi/16)/sqrt(N) = 0.135/sqrt(N). 2 N times the excess of H over its minimum, from 30
//! bins with a fitted mean square, is chi-square distributed with 28 degrees of freedom (Wilks, Ann. Math. Stat. 9
//! (1938) 60).
//! Setup: 2000 discs, R = 1 m, a = 4 mm, v_rms = 1 m/s; 20 s are about 250 collisions per disc.
//! Tolerance: 4.5 standard errors; chi-square below 60, whose probability of being exceeded is 1/3000.
//! Control: points without collisions are rejected.

// Tests compare with the platform's functions; values written in a test are in range.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::runs::{advance, channel, count, frame, gas, max_speed, particles, positive};
use kinetoscope_manifest::model::{GasConfig, SpeedDistribution, SpeedScale};
use kinetoscope_manifest::quantity::NonNegative;
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::model::Target;
use kinetoscope_recording::channels::{GasEnergyBalance, GasInvariants};
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

/// Whether the speeds follow Maxwell's distribution by all three criteria.
fn is_maxwellian(gas: &Gas) -> bool {
    let n = f64::from(DISCS);
    let [mean_over_rms, fourth_moment] = moments(gas);
    let excess = channel::<GasEnergyBalance>(gas).relative_entropy;
    println!(
        "<v>/v_rms {mean_over_rms}, <v^4>/<v^2>^2 {fourth_moment}, 2 N excess of H {}",
        2.0 * n * excess
    );
    let mean_error = (1.0 - PI / 4.0 - PI / 16.0).sqrt() / n.sqrt();
    (mean_over_rms - PI.sqrt() / 2.0).abs() < 4.5 * mean_error
        && (fourth_moment - 2.0 * n / (n + 1.0)).abs() < 4.5 * 2.0 / n.sqrt()
        && 2.0 * n * excess < 60.0
}

#[test]
fn discs_relax_to_maxwell_and_points_do_not() {
    for distribution in [SpeedDistribution::Equal, SpeedDistribution::Uniform] {
        let mut discs = gas(&start(distribution, Some(0.004)), 14);
        assert!(!is_maxwellian(&discs));
        advance(&mut discs, Target::Time(20.0));
        assert!(is_maxwellian(&discs), "{distribution:?}");
        // Control.
        let mut points = gas(&start(distribution, None), 14);
        let before = channel::<GasEnergyBalance>(&points).relative_entropy;
        advance(&mut points, Target::Time(20.0));
        assert!(!is_maxwellian(&points), "{distribution:?}");
        assert!((channel::<GasEnergyBalance>(&points).relative_entropy - before).abs() < 1e-12);
    }
}

/// Law: H never rises, except for the scatter of a finite sample.
/// Tolerance: four standard deviations sqrt(2 28)/(2 N) = 0.0019.
#[test]
fn h_decreases_to_its_minimum() {
    let mut discs = gas(&start(SpeedDistribution::Equal, Some(0.004)), 15);
    let mut before = channel::<GasEnergyBalance>(&discs).relative_entropy;
    let first = before;
    for step in 1..=20 {
        advance(&mut discs, Target::Time(0.05 * f64::from(step)));
        let now = channel::<GasEnergyBalance>(&discs).relative_entropy;
        assert!(now < before + 4.0 * 0.0019, "from {before} to {now}");
        before = now;
    }
    println!("H above its minimum: {first} at first, {before} after 12 collisions per disc");
    assert!(first > 1.0 && before < 0.02);
}

/// Law: equipartition; in a mixture of masses, <m v^2> is the same for each mass.
/// Setup: masses 1 : 4 at equal speeds, so that the heavy discs have 8/5 of the mean energy at first.
/// Tolerance: 4.5 standard errors, 1/sqrt(N) of the mean for halves of N/2 discs (exponential energies at fixed total
/// energy).
#[test]
fn masses_have_equal_mean_energy() {
    let mut config = start(SpeedDistribution::Equal, Some(0.004));
    config.additional_masses_kg = vec![positive(4.0 * config.mass_kg.get())];
    let heavy_energy_ratio = |gas: &Gas| {
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
    assert!((heavy_energy_ratio(&discs) - 1.6).abs() < 1e-12);
    advance(&mut discs, Target::Time(30.0));
    println!("energy of the heavy half over the mean: {}", heavy_energy_ratio(&discs));
    assert!((heavy_energy_ratio(&discs) - 1.0).abs() < 4.5 / f64::from(DISCS).sqrt());
}

/// Guarantee: a row of a mixture has the mass of its particle: the kinetic energy follows from the rows alone. It would not with one mass
/// for all.
#[test]
fn energy_of_a_mixture_follows_from_its_rows() {
    let mut config = start(SpeedDistribution::Equal, None);
    config.additional_masses_kg = vec![positive(3.1e-26), positive(0.7e-26)];
    let gas = gas(&config, 16);
    let frame = frame(&gas);
    let energy_j = |mass_kg: &dyn Fn(&[f64]) -> f64| -> f64 {
        let rows = frame.state().chunks_exact(5);
        rows.map(|row| mass_kg(row) * (row[2] * row[2] + row[3] * row[3]) / 2.0).sum()
    };
    let recorded_j = frame.get::<GasInvariants>().unwrap().kinetic_j;
    assert!((energy_j(&|row| row[4]) / recorded_j - 1.0).abs() < 1e-12);
    assert!((energy_j(&|_| gas.masses_kg()[0]) / recorded_j - 1.0).abs() > 0.1);
    let masses: Vec<f64> = frame.state().chunks_exact(5).map(|row| row[4]).take(4).collect();
    assert_eq!(masses, [config.mass_kg.get(), 3.1e-26, 0.7e-26, config.mass_kg.get()]);
}

/// Guarantee: given speeds are assigned to the particles cyclically, unchanged or scaled to a temperature.
#[test]
fn given_speeds_are_assigned_cyclically() {
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
    for (found, expected) in found(&config).iter().zip([1.0, 2.0, 0.0, 1.0, 2.0, 0.0, 1.0]) {
        assert!((found - expected).abs() < 1e-15);
    }
    config.speed_scale = crate::runs::kelvin(300.0);
    let scaled = found(&config);
    assert!((scaled[1] / scaled[0] - 2.0).abs() < 1e-14 && scaled[2] == 0.0);
}
