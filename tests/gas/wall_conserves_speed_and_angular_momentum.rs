//! Law: a specular wall conserves each particle's speed and its angular momentum about the center, and keeps it inside.
//!
//! Source: specular reflection in a circle.
//! Setup: a thousand particles for thousands of wall collisions each, exact and stepped; a single particle whose
//! numbers are all known.
//! Tolerance: 1e-12 of v and of m r v, for thousands of collisions with a rounding of 2^-53, which accumulate at random
//! in steps.
//! Control: the scheme as printed in the gas exercise loses particles and changes angular momenta.

use crate::runs::{advance, channel, count, exercise, gas, given, max_speed, particles, positive};
use kinetoscope_manifest::model::{GasConfig, Propagation};
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_recording::channels::{GasCollisions, GasInvariants};

fn long_run(propagation: Propagation) -> GasConfig {
    GasConfig {
        speed_scale: max_speed(1.0),
        duration_s: positive(5000.0),
        propagation,
        ..exercise()
    }
}

#[test]
fn speed_and_angular_momentum_are_conserved_and_no_particle_leaves() {
    for propagation in [
        Propagation::Exact,
        Propagation::TimeStepped { time_step_s: positive(0.1) },
        Propagation::TimeStepped { time_step_s: positive(10.0) },
    ] {
        let mut gas = gas(&long_run(propagation), 14);
        let start = channel::<GasInvariants>(&gas);
        let mut max_change = [0.0, 0.0];
        for frame in 1..=20 {
            advance(&mut gas, Target::Time(250.0 * f64::from(frame)));
            let now = channel::<GasInvariants>(&gas);
            assert_eq!(now.particles_outside, 0);
            assert!((now.kinetic_j / start.kinetic_j - 1.0).abs() < 1e-12);
            let change = (now.angular_momentum_j_s - start.angular_momentum_j_s).abs();
            // A thousand particles, each within 1e-12 m r v.
            assert!(change < 1e-12 * 1000.0 * 1e-26);
            let changes = [now.max_speed_change_relative, now.max_angular_momentum_change_relative];
            for (max, change) in max_change.iter_mut().zip(changes) {
                *max = if change > *max { change } else { *max };
            }
        }
        let collisions = channel::<GasCollisions>(&gas).wall_collisions;
        println!(
            "{propagation:?}: {collisions} wall collisions, speed {:e}, angular momentum {:e}",
            max_change[0], max_change[1]
        );
        assert!(collisions > 1_000_000);
        assert!(max_change[0] < 1e-12 && max_change[1] < 1e-12);
        assert!(max_change[0] > 0.0, "the change of speed is not measured");
    }
}

#[test]
fn control_printed_scheme_is_rejected() {
    let literal = Propagation::AsPrinted { time_step_s: positive(0.1) };
    let mut gas = gas(&long_run(literal), 14);
    advance(&mut gas, Target::Time(100.0));
    let now = channel::<GasInvariants>(&gas);
    println!(
        "outside {}, angular momentum {:e}",
        now.particles_outside, now.max_angular_momentum_change_relative
    );
    assert!(now.particles_outside > 0);
}

#[test]
fn control_printed_scheme_changes_angular_momenta_if_the_center_is_not_the_origin() {
    let center_m =
        [3.0, 1.0].map(|axis| kinetoscope_manifest::quantity::Finite::new(axis).unwrap());
    let literal = Propagation::AsPrinted { time_step_s: positive(0.1) };
    let mut gas = gas(&GasConfig { center_m, ..long_run(literal) }, 14);
    advance(&mut gas, Target::Time(100.0));
    let now = channel::<GasInvariants>(&gas);
    println!(
        "outside {}, angular momentum {:e}",
        now.particles_outside, now.max_angular_momentum_change_relative
    );
    assert!(now.particles_outside > 900);
    assert!(now.max_angular_momentum_change_relative > 0.1);
}

#[test]
fn single_particle_has_the_invariants_of_its_initial_state() {
    // p = (0.6, 0), v = (0, 2): m v^2 / 2 = 2e-26 J, m p x v = 1.2e-26 J s.
    let mut gas = gas(&given(&[([0.6, 0.0], [0.0, 2.0])]), 1);
    for time in [0.0, 0.4, 10.0, 1000.0] {
        advance(&mut gas, Target::Time(time));
        let now = channel::<GasInvariants>(&gas);
        assert!((now.kinetic_j / 2e-26 - 1.0).abs() < 1e-12);
        assert!((now.angular_momentum_j_s / 1.2e-26 - 1.0).abs() < 1e-12);
    }
    // Half chord 0.8: the first collision is at 0.4 s, then one per 0.8 s.
    assert_eq!(gas.count(), 1250);
    assert_eq!(particles(&gas).len(), 1);
    let mut one = crate::runs::gas(&GasConfig { particles: count(1), ..exercise() }, 1);
    advance(&mut one, Target::Time(0.1));
    assert_eq!(channel::<GasInvariants>(&one).particles_outside, 0);
}
