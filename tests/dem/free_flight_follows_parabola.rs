//! Law: between contacts y = y0 + v t - g t^2/2 exactly, at every step, with v the velocity of the start at the positions' time:
//! v0 for velocity Verlet, v0 - g dt/2 for semi-implicit Euler, which begins half a step later; and the energy is constant.
//!
//! Source: x_n = x0 + sum (v0 - g j dt) dt over j = 1..n, in closed form.
//! Setup: a disc thrown upwards, 4000 steps; N_t = 20.
//! Tolerance: 4000 rounded additions, 1e-14 m; energy 1e-12 relative.

use crate::scene::{discs, energy, given, prepared, run_to, time_step};
use kinetoscope_manifest::model::{DemConfig, DemIntegrator};

const START: [f64; 2] = [0.01, 0.01];
const VELOCITY: [f64; 2] = [0.1, 0.6];

/// Largest distance from the parabola with the acceleration `g`, m.
fn largest_error(integrator: DemIntegrator, g: f64) -> f64 {
    let config = DemConfig { integrator, ..DemConfig::default() };
    let mut model = prepared(&given(config, &[(START, VELOCITY)]));
    let step = time_step(&model);
    let half_step = match integrator {
        DemIntegrator::VelocityVerlet => 0.0,
        DemIntegrator::SemiImplicitEuler | DemIntegrator::ImplicitDashpot => 0.5 * step,
    };
    let before = energy(&model).total_j;
    let mut largest = 0.0;
    for count in (0..=4000).step_by(40) {
        run_to(&mut model, count);
        let time = count as f64 * step;
        let disc = discs(&model)[0];
        let height = START[1] + (VELOCITY[1] - g * half_step) * time - 0.5 * g * time * time;
        let error = (disc.position[1] - height).abs()
            + (disc.position[0] - START[0] - VELOCITY[0] * time).abs();
        largest = if error > largest { error } else { largest };
        let speed = VELOCITY[1] - g * (half_step + time);
        assert!(g != 9.81 || (disc.velocity[1] - speed).abs() < 1e-12);
        assert!((energy(&model).total_j / before - 1.0).abs() < 1e-12);
    }
    largest
}

#[test]
fn the_path_is_the_parabola() {
    for integrator in [
        DemIntegrator::SemiImplicitEuler,
        DemIntegrator::VelocityVerlet,
        DemIntegrator::ImplicitDashpot,
    ] {
        let error = largest_error(integrator, 9.81);
        println!("{integrator:?}: {error:.1e} m");
        assert!(error < 1e-14, "{integrator:?}: {error:e}");
        // Control.
        assert!(largest_error(integrator, 9.81 * (1.0 + 1e-9)) > 1e-12);
    }
}
