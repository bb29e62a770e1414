//! Law: velocity Verlet is v_h = v + a dt/2, x' = x + v_h dt, a' = F(x', v_h)/m, v' = v_h + a' dt/2 (half kick, drift,
//! half kick), with the dashpot evaluated at the half-step velocity.
//!
//! Source: Swope et al., J. Chem. Phys. 76 (1982) 637, written out here in its published form; the program executes one
//! kick per step with a different initial velocity. The dashpot is evaluated as in LAMMPS.
//! Setup: a disc that rebounds from the floor four times, e = 0.7, N_t = 20; positions and velocities compared at each step.
//! Tolerance: 1e-12 m and m/s, rounding amplified by the rebounds.
//! Control: semi-implicit Euler is rejected.

use crate::scene::{discs, given, prepared, restitution, run_to, time_step};
use kinetoscope_manifest::model::{DemConfig, DemIntegrator};
use kinetoscope_physics::dem::restitution::damping_ratio;

const RADIUS: f64 = 5e-4;
const MASS: f64 = 1e-3;
const STIFFNESS: f64 = 5e4;

fn acceleration(y: f64, velocity: f64) -> f64 {
    let overlap = RADIUS - y;
    let zeta = damping_ratio(0.7, false);
    let damping = 2.0 * zeta * (STIFFNESS * MASS).sqrt();
    let force = if overlap > 0.0 { STIFFNESS * overlap - damping * velocity } else { 0.0 };
    force / MASS - 9.81
}

/// Largest difference in position and velocity between the program and the published form, and the number of rebounds.
fn max_difference(integrator: DemIntegrator) -> (f64, u32) {
    let config = DemConfig { integrator, dissipation: restitution(0.7), ..DemConfig::default() };
    let mut model = prepared(&given(config, &[([0.02, 0.002], [0.0, 0.0])]));
    let step = time_step(&model);
    let (mut y, mut velocity, mut a) = (0.002, 0.0, -9.81);
    let (mut max, mut rebounds) = (0.0, 0);
    for count in 1..=4000 {
        let half = velocity + 0.5 * step * a;
        y += step * half;
        a = acceleration(y, half);
        let next = half + 0.5 * step * a;
        rebounds += u32::from(velocity < 0.0 && next >= 0.0);
        velocity = next;
        run_to(&mut model, count);
        let disc = discs(&model)[0];
        let difference = (disc.position[1] - y).abs() + (disc.velocity[1] - velocity).abs();
        max = if difference > max { difference } else { max };
    }
    (max, rebounds)
}

#[test]
fn trajectory_equals_kick_drift_kick() {
    let (difference, rebounds) = max_difference(DemIntegrator::VelocityVerlet);
    println!("{difference:.1e} after {rebounds} rebounds");
    assert!(rebounds >= 4, "{rebounds}");
    assert!(difference < 1e-12, "{difference:e}");
}

#[test]
fn control_semi_implicit_euler_is_rejected() {
    assert!(max_difference(DemIntegrator::SemiImplicitEuler).0 > 1e-6);
}
