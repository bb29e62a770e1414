//! Law: between contacts, y = y0 + v t - g t^2/2 at every step, and the energy is constant. The initial velocity v at
//! the time of the positions is v0 for velocity Verlet and v0 - g dt/2 for semi-implicit Euler, whose velocities lag by
//! half a step.
//!
//! Source: x_n = x0 + sum (v0 - g j dt) dt over j = 1..n, in closed form.
//! Setup: a disc thrown upwards, 4000 steps; N_t = 20; every integrator.
//! Tolerance: 1e-14 m for 4000 rounded additions; 1e-12 relative for the energy.
//! Control: a gravity larger by 1e-9 is rejected.

use crate::scene::{discs, energy, given, gravity, prepared, run_to, time_step};
use kinetoscope_manifest::model::{DemConfig, DemDashpot, DemIntegrator};

const START: [f64; 2] = [0.01, 0.01];
const VELOCITY: [f64; 2] = [0.1, 0.6];

/// Largest distance from the parabola with acceleration `g`, m.
fn max_error((integrator, dashpot): (DemIntegrator, DemDashpot), g: f64) -> f64 {
    let config = DemConfig { integrator, dashpot, ..DemConfig::default() };
    let mut model = prepared(&given(config, &[(START, VELOCITY)]));
    let step = time_step(&model);
    let half_step = match integrator {
        DemIntegrator::VelocityVerlet => 0.0,
        DemIntegrator::SemiImplicitEuler => 0.5 * step,
    };
    let before = energy(&model).total_j;
    let mut max_error = 0.0;
    for count in (0..=4000).step_by(40) {
        run_to(&mut model, count);
        let time = count as f64 * step;
        let disc = discs(&model)[0];
        let height = START[1] + (VELOCITY[1] - g * half_step) * time - 0.5 * g * time * time;
        let error = (disc.position[1] - height).abs()
            + (disc.position[0] - START[0] - VELOCITY[0] * time).abs();
        max_error = if error > max_error { error } else { max_error };
        let speed = VELOCITY[1] - g * (half_step + time);
        assert!(g != 9.81 || (disc.velocity[1] - speed).abs() < 1e-12);
        assert!((energy(&model).total_j / before - 1.0).abs() < 1e-12);
    }
    max_error
}

#[test]
fn free_flight_follows_the_parabola_at_constant_energy() {
    for integrator in [
        (DemIntegrator::SemiImplicitEuler, DemDashpot::Explicit),
        (DemIntegrator::VelocityVerlet, DemDashpot::Explicit),
        (DemIntegrator::SemiImplicitEuler, DemDashpot::Implicit),
        (DemIntegrator::VelocityVerlet, DemDashpot::Implicit),
    ] {
        let error = max_error(integrator, 9.81);
        println!("{integrator:?}: {error:.1e} m");
        assert!(error < 1e-14, "{integrator:?}: {error:e}");
        // Control.
        assert!(max_error(integrator, 9.81 * (1.0 + 1e-9)) > 1e-12);
    }
}

/// Velocity in the first frame of the disc, with gravity along both axes.
fn first_velocity(config: DemConfig) -> [f64; 2] {
    let gravity_m_per_s2 = gravity(-3.0, -9.81);
    discs(&prepared(&given(DemConfig { gravity_m_per_s2, ..config }, &[(START, VELOCITY)])))[0]
        .velocity
}

/// Tolerance: 1e-15 m/s, for the half kick that is subtracted and added.
#[test]
fn first_recorded_velocity_is_the_requested_one() {
    let difference = |velocity: [f64; 2]| [0, 1].map(|axis: usize| velocity[axis] - VELOCITY[axis]);
    for dashpot in [DemDashpot::Explicit, DemDashpot::Implicit] {
        let first = difference(first_velocity(DemConfig { dashpot, ..DemConfig::default() }));
        assert!(first.iter().all(|axis| axis.abs() < 1e-15), "{first:?}");
        // Control: semi-implicit Euler records the requested velocity plus half a step of gravity.
        let integrator = DemIntegrator::SemiImplicitEuler;
        let control = DemConfig { integrator, dashpot, ..DemConfig::default() };
        let half_step = 0.5 * time_step(&prepared(&control));
        let [x, y] = difference(first_velocity(control));
        assert!((x + 3.0 * half_step).abs() < 1e-15 && (y + 9.81 * half_step).abs() < 1e-15);
    }
}

/// The DEM exercise's discs start at rest: the first frame has their positions and velocities to the last digit.
#[test]
fn first_frame_of_discs_at_rest_is_the_requested_one() {
    let wanted = [[0.012_345_678_901_234_5, 0.031], [1.0 / 30.0, 0.1 + 0.2 - 0.28]];
    let at_rest = wanted.map(|position| (position, [0.0, 0.0]));
    let first = |integrator| {
        discs(&prepared(&given(DemConfig { integrator, ..DemConfig::default() }, &at_rest)))
    };
    let found = first(DemIntegrator::VelocityVerlet);
    assert_eq!([found[0].position, found[1].position], wanted);
    assert!(found.iter().all(|disc| disc.velocity == [0.0, 0.0]), "{found:?}");
    // Control: semi-implicit Euler begins half a step earlier.
    let control = first(DemIntegrator::SemiImplicitEuler);
    assert!(control.iter().all(|disc| disc.velocity[1] < 0.0), "{control:?}");
}
