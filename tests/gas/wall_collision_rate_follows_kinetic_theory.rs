//! Law: in the uniform isotropic state, sin a = d/R is uniform on [-1, 1] at the wall collisions, the mean chord is pi
//! R/2, and the wall collision rate of a particle of speed v is 2 v/(pi R).
//!
//! Source: kinetic theory; Cauchy's mean chord of a disc, pi A / perimeter.
//! Setup: equal speeds of 1 m/s in a circle of radius 1, uniform initial positions.
//! Tolerance: derived at each test; four standard errors, or 1.95/sqrt(n), the Kolmogorov-Smirnov bound for a
//! probability of 1/1000.
//! Control: the sines of all particles, instead of those at the wall, are rejected.

// Tests compare with the platform's functions and do not affect recorded bits.
#![allow(clippy::disallowed_methods)]

use crate::runs::{advance, channel, count, gas, max_speed, particles, positive};
use kinetoscope_manifest::model::{GasConfig, SpeedDistribution};
use kinetoscope_physics::gas::time_stepped;
use kinetoscope_physics::model::Target;
use kinetoscope_recording::channels::{GasCollisions, GasInvariants};
use std::f64::consts::PI;

fn equal_speeds(particles: u32) -> GasConfig {
    GasConfig {
        particles: count(particles),
        speed_distribution: SpeedDistribution::Equal,
        speed_scale: max_speed(1.0),
        duration_s: positive(1000.0),
        ..GasConfig::default()
    }
}

/// Largest difference between the cumulative distribution of the sines and the uniform one on [-1, 1].
fn distance_from_uniform(mut sines: Vec<f64>) -> f64 {
    sines.sort_by(f64::total_cmp);
    let n = sines.len() as f64;
    sines.iter().enumerate().fold(0.0, |max, (index, sine)| {
        let expected = f64::midpoint(1.0, *sine);
        let below = (expected - index as f64 / n).abs();
        f64::max(max, f64::max(below, ((index + 1) as f64 / n - expected).abs()))
    })
}

#[test]
fn sines_at_wall_collisions_are_uniform_and_the_mean_chord_is_half_pi() {
    // The duration is a tenth of the mean time between collisions, so that collisions belong to different particles and
    // are independent.
    let starts = particles(&gas(&equal_speeds(200_000), 14));
    let mut sines = Vec::new();
    for start in &starts {
        let flight = time_stepped::step(*start, 1.0, 0.15);
        for _ in 0..flight.wall_collisions {
            sines.push(flight.particle.angular_momentum_per_mass());
        }
    }
    let n = sines.len() as f64;
    let chord = sines.iter().map(|sine| 2.0 * (1.0 - sine * sine).sqrt()).sum::<f64>() / n;
    let all: Vec<f64> = starts.iter().map(|p| p.angular_momentum_per_mass()).collect();
    let (found, bound) = (distance_from_uniform(sines), 1.95 / n.sqrt());
    let control = distance_from_uniform(all);
    println!(
        "{n} collisions: distance {found}, bound {bound}; all particles (control) {control}; chord {chord}"
    );
    assert!(found < bound);
    // The sines of all particles have the density of the chords, sqrt(1 - d^2).
    assert!(control > 2.0 * bound);
    // The variance of a chord with uniform sine is 8/3 - pi^2/4.
    assert!((chord - PI / 2.0).abs() < 4.0 * ((8.0 / 3.0 - PI * PI / 4.0) / n).sqrt());
}

#[test]
fn wall_collision_rate_is_two_v_over_pi_r() {
    // A particle on a chord 2C collides at the rate v/(2C): mean 2/pi, mean square <1/C^2>/4 = 1/2; the phase adds 1/6
    // in total.
    let time = 50.0;
    for seed in 0..5 {
        let mut gas = gas(&equal_speeds(10_000), seed);
        advance(&mut gas, Target::Time(time));
        let rate = channel::<GasCollisions>(&gas).wall_collisions as f64 / (1e4 * time);
        let variance = (0.5 - 4.0 / (PI * PI)) + 1.0 / (6.0 * time * time);
        let deviation = (rate - 2.0 / PI) / (variance / 1e4).sqrt();
        println!("rate {rate}, theory {}, {deviation} standard errors", 2.0 / PI);
        assert!(deviation.abs() < 4.0);
    }
}

#[test]
fn uniform_initial_state_stays_uniform() {
    // Fraction inside r/2, and the mean of (|p|/R)^2 = 1/2, at several times.
    let mut gas = gas(&equal_speeds(50_000), 2);
    for time in [0.0, 0.3, 1.7, 20.0, 1000.0] {
        advance(&mut gas, Target::Time(time));
        let squares: Vec<f64> = particles(&gas)
            .iter()
            .map(|p| p.position[0] * p.position[0] + p.position[1] * p.position[1])
            .collect();
        let inside = squares.iter().filter(|&&square| square < 0.25).count() as f64 / 5e4;
        let mean = squares.iter().sum::<f64>() / 5e4;
        println!("t = {time}: inside r/2 {inside}, mean square {mean}");
        assert!((inside - 0.25).abs() < 4.0 * (0.1875 / 5e4_f64).sqrt());
        assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12.0 / 5e4_f64).sqrt());
        assert_eq!(channel::<GasInvariants>(&gas).particles_outside, 0);
    }
}
