//! Law: steps of any length, with a reflection at every wall collision until the step is used up, follow the exact path.
//!
//! Source: gas exercise, equations (7) to (10) and the reflection, with u in (0, dt]. Reference values: 50-digit arithmetic.
//! Setup: single steps of given particles; runs with time steps from 1/128 to 4 times the time to cross a radius.
//! Tolerance: 1e-14 for a single collision, 1e-12 for eight collisions in a step, 1e-10 over 1000 radii (about 1e5
//! steps with a rounding of 2^-53).
//! Control: one reflection per step is rejected.

// Tests compare with the platform's functions and do not affect recorded bits; reference values keep all their digits.
#![allow(clippy::disallowed_methods, clippy::excessive_precision)]

use crate::runs::{
    advance, channel, exercise, gas, given, max_difference, max_speed, particles, positive,
};
use kinetoscope_manifest::model::{GasConfig, Propagation};
use kinetoscope_physics::gas::motion::{ChordPath, Particle, drifted, time_to_wall};
use kinetoscope_physics::gas::time_stepped;
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_recording::channels::{GasCollisions, GasPressure};

const START: Particle = Particle { position: [0.9, 0.1], velocity: [0.3, 0.2] };

fn stepped_by(time_step_s: f64, config: GasConfig) -> GasConfig {
    GasConfig {
        propagation: Propagation::TimeStepped { time_step_s: positive(time_step_s) },
        ..config
    }
}

#[test]
fn step_with_one_wall_collision_equals_the_reference() {
    let to_wall = time_to_wall(START, 1.0);
    assert!((to_wall - 0.29132250934692332782).abs() < 1e-15);
    let point = drifted(START, to_wall).position;
    assert!(max_difference(point, [0.98739675280407699835, 0.15826450186938466556]) < 1e-15);
    let flight = time_stepped::step(START, 1.0, 1.0);
    let Particle { position, velocity } = flight.particle;
    let error = max_difference(position, [0.74114595859487759064, 0.22645275965562619145])
        .max(max_difference(velocity, [-0.34747935056081539967, 0.096219025841223099504]));
    println!("one collision: error {error:e}");
    assert!(error < 1e-14);
    assert_eq!(flight.wall_collisions, 1);
}

#[test]
fn step_with_eight_wall_collisions_equals_the_reference() {
    let start = Particle { position: [0.0, 0.9995], velocity: [0.5, 0.0] };
    let flight = time_stepped::step(start, 1.0, 1.0);
    let error =
        max_difference(flight.particle.position, [0.47926562091714627893, 0.8771200251313990904]);
    println!("eight collisions: error {error:e}");
    assert!(error < 1e-12);
    assert_eq!(flight.wall_collisions, 8);
}

#[test]
fn step_with_thousands_of_wall_collisions_uses_the_closed_form() {
    // Flat chords have more collisions than are reflected individually, so the closed form is used, which another test
    // compares with polygons. A position outside by one rounding counts as on the wall.
    for height in [1e-4, 1e-8, 1e-12, 0.0, -f64::EPSILON] {
        let start = Particle { position: [0.0, 1.0 - height], velocity: [2.0, 0.0] };
        let flight = time_stepped::step(start, 1.0, 3.0);
        let distance = f64::hypot(flight.particle.position[0], flight.particle.position[1]);
        assert!(distance < 1.0 + 1e-12, "{height}: {distance}");
        assert!(flight.wall_collisions == 0 || flight.wall_collisions > 64);
        // In the limit, the particle slides along the wall with the impulse m s^2 t / R.
        assert!((flight.impulse_per_mass - 12.0).abs() < 0.1 + 10.0 * height.abs().sqrt());
    }
}

#[test]
fn every_time_step_follows_the_exact_path() {
    // The two paths of the 50-digit reference in `exact_motion_equals_50_digit_reference`, with 426 and 1174 wall
    // collisions.
    let starts = [([0.3, -0.2], [0.7, 0.4]), ([0.9, 0.1], [-0.11, 0.99])];
    let expected = [
        (
            [-0.026210589698213708, 0.33460058332687535],
            [-0.75486490547545295, -0.28315892089343659],
        ),
        (
            [-0.067901540170974276, -0.90649676968641987],
            [0.99600836505727178, 0.012935870126916093],
        ),
    ];
    for time_step in [1.0 / 128.0, 1.0 / 16.0, 0.25, 1.0, 4.0] {
        let mut gas = gas(&stepped_by(time_step, given(&starts)), 1);
        let steps = (1000.0 / time_step) as u64;
        assert_eq!(gas.extent(), Extent::Steps { total: steps, step: time_step });
        advance(&mut gas, Target::Count(steps));
        assert_eq!(gas.time(), 1000.0);
        let mut error = 0.0;
        for (end, (position, velocity)) in particles(&gas).iter().zip(expected) {
            error = f64::max(error, max_difference(end.position, position));
            error = f64::max(error, max_difference(end.velocity, velocity));
        }
        println!("dt = {time_step}: error {error:e}");
        assert!(error < 1e-10);
        assert_eq!(channel::<GasCollisions>(&gas).wall_collisions, 426 + 1174);
    }
}

#[test]
fn control_one_reflection_per_step_is_rejected() {
    let mut particle = Particle { position: [0.9, 0.1], velocity: [-0.11, 0.99] };
    for _ in 0..1000 {
        particle = one_reflection(particle, 1.0);
    }
    let error = max_difference(particle.position, [-0.067901540170974276, -0.90649676968641987]);
    println!("control: error {error:e}");
    assert!(error > 1e-10);
}

/// The scheme of the exercise with all corrections except that it reflects at most once per step.
fn one_reflection(particle: Particle, time_step: f64) -> Particle {
    let to_wall = time_to_wall(particle, 1.0);
    if to_wall >= time_step {
        return drifted(particle, time_step);
    }
    // The flight ends just after the collision; the rest of the step ignores further collisions.
    let after = ChordPath::of(particle, 1.0).flight(to_wall * (1.0 + 1e-15)).particle;
    drifted(after, time_step - to_wall)
}

#[test]
fn stepped_gas_equals_the_gas_by_closed_form() {
    let exact = GasConfig { speed_scale: max_speed(1.0), duration_s: positive(40.0), ..exercise() };
    let mut closed_form = gas(&exact, 5);
    advance(&mut closed_form, Target::Time(40.0));
    for time_step in [0.03125, 0.5, 4.0] {
        let mut stepped = gas(&stepped_by(time_step, exact.clone()), 5);
        advance(&mut stepped, Target::Time(40.0));
        let mut error = 0.0;
        for (a, b) in particles(&stepped).iter().zip(particles(&closed_form)) {
            error = f64::max(error, max_difference(a.position, b.position));
            error = f64::max(error, max_difference(a.velocity, b.velocity));
        }
        println!("dt = {time_step}: largest difference {error:e}");
        // Grazing paths amplify the rounding of the initial state by R/C, and a thousand particles contain some with C
        // of 1e-2.
        assert!(error < 1e-10);
        let pressure = channel::<GasPressure>(&stepped).measured_since_start_n_per_m;
        let expected = channel::<GasPressure>(&closed_form).measured_since_start_n_per_m;
        assert!((pressure / expected - 1.0).abs() < 1e-12);
        assert_eq!(channel::<GasCollisions>(&stepped), channel::<GasCollisions>(&closed_form));
    }
}

#[test]
fn step_budget_changes_no_bit() {
    let config = stepped_by(1e-5, exercise());
    let mut at_once = gas(&config, 8);
    advance(&mut at_once, Target::Count(1000));
    advance(&mut at_once, Target::Count(2000));
    for budget in [1, 7] {
        let mut in_parts = gas(&config, 8);
        for target in [1000, 2000] {
            let mut calls = 1;
            while in_parts.advance(Target::Count(target), budget).unwrap() == Progress::Working {
                calls += 1;
            }
            assert_eq!(calls, 1000_u64.div_ceil(budget));
        }
        assert_eq!(in_parts, at_once);
    }
}
