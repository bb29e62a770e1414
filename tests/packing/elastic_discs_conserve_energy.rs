//! Law: the sum of v^2 / 2 of elastic discs is constant in pair collisions and in collisions with walls that rotate the
//! outgoing direction at random.
//!
//! Source: packing exercise, equation 2 (the rotation is an isometry) and `colisiona` with alpha = 1.
//! Setup: 100 discs at fraction 0.3, the exercise's wall noise, 1,000,000 collisions, 200 frames.
//! Tolerance: 1e-12, relative. A collision rounds the energy of a disc by about 1e-16; 20,000 collisions per disc add
//! up to 1e-14 with random signs and to 2e-12 of that disc with equal signs.
//! Control: restitution 1 - 1e-9, and the wall rule as printed in the exercise, which uses the updated vx, are rejected.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods)]

use crate::runs::{
    advance_to_count, at_fraction, message, prepare, squared_speed, with_restitution,
};
use kinetoscope_manifest::model::PackingConfig;
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::PackingTemperature;

const TOLERANCE: f64 = 1e-12;

fn max_relative_change(energies: &[f64]) -> f64 {
    energies.iter().map(|energy| (energy / energies[0] - 1.0).abs()).fold(0.0, f64::max)
}

fn energies(config: &PackingConfig, events: u64, frames: u64) -> Vec<f64> {
    let mut packing = prepare(config, 1, 0);
    let mut energies = vec![message::<PackingTemperature>(&packing).kinetic_energy];
    for frame in 1..=frames {
        advance_to_count(&mut packing, events * frame / frames);
        energies.push(message::<PackingTemperature>(&packing).kinetic_energy);
    }
    assert_eq!(packing.count(), events);
    energies
}

#[test]
fn energy_is_conserved_in_a_million_collisions() {
    let change = max_relative_change(&energies(&at_fraction(100, 0.3), 1_000_000, 200));
    println!("largest relative change of the energy: {change:e}");
    assert!(change < TOLERANCE);
}

#[test]
fn control_tiny_inelasticity_is_rejected() {
    let config = with_restitution(at_fraction(100, 0.3), 1.0 - 1e-9);
    assert!(max_relative_change(&energies(&config, 10_000, 10)) > TOLERANCE);
}

/// The exercise's `pcolisiona` rotates vy with the vx that it has just rotated.
#[test]
fn control_printed_wall_rule_is_rejected() {
    let mut velocity = [0.6, 0.8];
    let mut energies = vec![0.5 * squared_speed(velocity)];
    for wall in 0..100 {
        let angle: f64 = if wall % 2 == 0 { 0.056 } else { -0.056 };
        velocity[wall % 2] = -velocity[wall % 2];
        velocity[0] = velocity[0] * angle.cos() - velocity[1] * angle.sin();
        velocity[1] = velocity[0] * angle.sin() + velocity[1] * angle.cos();
        energies.push(0.5 * squared_speed(velocity));
    }
    assert!(max_relative_change(&energies) > 1e-3);
}
