//! Law: velocity Verlet is half kick, drift, half kick, with the dashpot at the half-step velocity.
//!
//! v_h = v + a dt/2, x' = x + v_h dt, a' = F(x', v_h)/m, v' = v_h + a' dt/2.
//! Source: written out here as it stands in the books (Swope et al., J. Chem. Phys. 76 (1982) 637), where the program has
//! one kick a step and another start; dashpot as LAMMPS evaluates it.
//! Setup: a disc that bounces on the floor four times, e = 0.7, N_t = 20; positions and velocities compared at each step.
//! Tolerance: rounding, grown by the bounces: 1e-12 m and m/s.

use crate::scene::{discs, given, prepared, restitution, run_to, time_step};
use kinetoscope_manifest::model::{DemConfig, DemIntegrator, ForceTail};
use kinetoscope_physics::dem::restitution::damping_ratio;

const RADIUS: f64 = 5e-4;
const MASS: f64 = 1e-3;
const STIFFNESS: f64 = 5e4;

fn acceleration(y: f64, velocity: f64) -> f64 {
    let overlap = RADIUS - y;
    let zeta = damping_ratio(0.7, ForceTail::Attractive);
    let damping = 2.0 * zeta * (STIFFNESS * MASS).sqrt();
    let force = if overlap > 0.0 { STIFFNESS * overlap - damping * velocity } else { 0.0 };
    force / MASS - 9.81
}

/// Largest difference between the program's and the book's positions and velocities, and the bounces seen.
fn largest_difference(integrator: DemIntegrator) -> (f64, u32) {
    let config = DemConfig { integrator, dissipation: restitution(0.7), ..DemConfig::default() };
    let mut model = prepared(&given(config, &[([0.02, 0.002], [0.0, 0.0])]));
    let step = time_step(&model);
    let (mut y, mut velocity, mut a) = (0.002, 0.0, -9.81);
    let (mut largest, mut bounces) = (0.0, 0);
    for count in 1..=4000 {
        let half = velocity + 0.5 * step * a;
        y += step * half;
        a = acceleration(y, half);
        let next = half + 0.5 * step * a;
        bounces += u32::from(velocity < 0.0 && next >= 0.0);
        velocity = next;
        run_to(&mut model, count);
        let disc = discs(&model)[0];
        let difference = (disc.position[1] - y).abs() + (disc.velocity[1] - velocity).abs();
        largest = if difference > largest { difference } else { largest };
    }
    (largest, bounces)
}

#[test]
fn the_trajectory_is_the_books() {
    let (difference, bounces) = largest_difference(DemIntegrator::VelocityVerlet);
    println!("{difference:.1e} after {bounces} bounces");
    assert!(bounces >= 4, "{bounces}");
    assert!(difference < 1e-12, "{difference:e}");
}

/// Control: the other start is another trajectory.
#[test]
fn semi_implicit_euler_is_told_apart() {
    assert!(largest_difference(DemIntegrator::SemiImplicitEuler).0 > 1e-6);
}
