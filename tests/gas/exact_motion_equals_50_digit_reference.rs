//! Law: a particle in a circle moves along chords of equal length, each rotated by beta = pi - 2 asin(d/R) relative to
//! the previous one: p(t) = Rot(k beta) [(b0 + s t - 2 C k) v^ - d n^], v(t) = Rot(k beta) v0.
//!
//! Source: gas exercise 14g1, equations (7), (9) and the reflection; circular billiard. REFERENCES: 50-digit
//! arithmetic; regular polygons, whose corners are known.
//! Setup: given particles in a circle of radius 1.
//! Tolerance: 1e-9 after 1174 wall collisions (path of 1000 radii, rounding of 2^-53 per radius and collision, sum
//! below 1e-12); counts of collisions are exact.
//! Control: a wall that returns a fraction 1 - 1e-9 of the normal velocity is rejected.

// Tests compare with the platform's functions and do not affect recorded bits; reference values keep all their digits.
#![allow(clippy::disallowed_methods, clippy::excessive_precision)]

use crate::runs::{advance, channel, gas, given, max_difference, particles, positive};
use kinetoscope_manifest::model::GasConfig;
use kinetoscope_manifest::quantity::Finite;
use kinetoscope_physics::gas::motion::{Particle, drifted, time_to_wall};
use kinetoscope_physics::model::{Extent, Model, Target};
use kinetoscope_recording::channels::{GasCollisions, GasInvariants, GasPressure};
use std::f64::consts::PI;

type Reference = (([f64; 2], [f64; 2]), u64, [f64; 2], [f64; 2]);

/// Initial state, wall collisions, position and velocity at t = 1000, R = 1 (50-digit arithmetic).
const REFERENCES: [Reference; 2] = [
    (
        ([0.3, -0.2], [0.7, 0.4]),
        426,
        [-0.026210589698213708, 0.33460058332687535],
        [-0.75486490547545295, -0.28315892089343659],
    ),
    (
        ([0.9, 0.1], [-0.11, 0.99]),
        1174,
        [-0.067901540170974276, -0.90649676968641987],
        [0.99600836505727178, 0.012935870126916093],
    ),
];

#[test]
fn path_after_a_thousand_wall_collisions_equals_the_reference() {
    for (start, collisions, position, velocity) in REFERENCES {
        let mut gas = gas(&given(&[start]), 1);
        assert_eq!(gas.extent(), Extent::Time(1000.0));
        advance(&mut gas, Target::Time(1000.0));
        let end = particles(&gas)[0];
        let error =
            max_difference(end.position, position).max(max_difference(end.velocity, velocity));
        println!("{collisions} wall collisions: error {error:e}");
        assert!(error < 1e-9);
        assert_eq!(channel::<GasCollisions>(&gas).wall_collisions, collisions);
        assert_eq!(gas.count(), collisions);
    }
}

/// The same path from collision to collision, with a wall that returns a fraction of the normal velocity; the law is 1.
fn event_by_event(start: ([f64; 2], [f64; 2]), collisions: u64, returned: f64) -> [f64; 2] {
    let mut particle = Particle { position: start.0, velocity: start.1 };
    let mut rest = 1000.0;
    for _ in 0..collisions {
        let time = time_to_wall(particle, 1.0);
        rest -= time;
        let point = drifted(particle, time).position;
        let [vx, vy] = particle.velocity;
        let square = point[0] * point[0] + point[1] * point[1];
        let change = (1.0 + returned) * (vx * point[0] + vy * point[1]) / square;
        particle = Particle {
            position: point,
            velocity: [vx - change * point[0], vy - change * point[1]],
        };
    }
    drifted(particle, rest).position
}

#[test]
fn control_wall_with_a_tiny_loss_is_rejected() {
    for (start, collisions, position, _) in REFERENCES {
        let error =
            |returned| max_difference(event_by_event(start, collisions, returned), position);
        println!(
            "{collisions} wall collisions: specular {:e}, lossy wall {:e}",
            error(1.0),
            error(1.0 - 1e-9)
        );
        assert!(error(1.0) < 1e-9);
        assert!(error(1.0 - 1e-9) > 1e-9);
    }
}

#[test]
fn regular_polygons_close_after_their_corners() {
    // The particle moves from (R, 0) along the first side of a regular n-gon; after j sides, it is at corner j.
    for corners in [2_u32, 3, 4, 5, 12, 1000] {
        let angle = 2.0 * PI / f64::from(corners);
        let corner = |j: f64| [(j * angle).cos(), (j * angle).sin()];
        let side = 2.0 * (angle / 2.0).sin();
        let velocity = [(corner(1.0)[0] - 1.0) / side, corner(1.0)[1] / side];
        for sides in [0.5, 1.5, 7.25, 1000.5] {
            let mut gas = gas(&given(&[([1.0, 0.0], velocity)]), 1);
            advance(&mut gas, Target::Time(sides * side));
            let done = f64::floor(sides);
            let fraction = sides - done;
            let (from, to) = (corner(done), corner(done + 1.0));
            let expected = [0, 1].map(|axis| from[axis] + fraction * (to[axis] - from[axis]));
            let error = max_difference(particles(&gas)[0].position, expected);
            assert!(error < 1e-10, "{corners} corners, {sides} sides: {error:e}");
            assert_eq!(channel::<GasCollisions>(&gas).wall_collisions, done as u64);
            let sine = (angle / 2.0).sin();
            let impulse = 1e-26 * done * 2.0 * sine;
            let pressure = channel::<GasPressure>(&gas);
            assert!((pressure.wall_impulse_n_s - impulse).abs() <= 1e-12 * impulse);
        }
    }
}

#[test]
fn every_initial_state_is_defined() {
    let at = |start, time| {
        let mut gas = gas(&given(&[start]), 1);
        advance(&mut gas, Target::Time(time));
        let collisions = channel::<GasCollisions>(&gas).wall_collisions;
        (particles(&gas)[0], collisions, channel::<GasPressure>(&gas).wall_impulse_n_s)
    };
    // Initial state, time, position, velocity, wall collisions, each known without a formula.
    let known: [(_, f64, [f64; 2], [f64; 2], u64); 8] = [
        // At rest: inside, at the center, on the wall.
        (([0.3, 0.4], [0.0, 0.0]), 7.0, [0.3, 0.4], [0.0, 0.0], 0),
        (([0.0, 0.0], [0.0, 0.0]), 7.0, [0.0, 0.0], [0.0, 0.0], 0),
        (([0.6, 0.8], [0.0, 0.0]), 7.0, [0.6, 0.8], [0.0, 0.0], 0),
        // Radial, from the center and from another position: back and forth on a diameter.
        (([0.0, 0.0], [1.0, 0.0]), 3.5, [-0.5, 0.0], [1.0, 0.0], 2),
        (([0.5, 0.0], [-2.0, 0.0]), 2.0, [0.5, 0.0], [-2.0, 0.0], 2),
        // On the wall: outward motion collides at once, inward motion later.
        (([1.0, 0.0], [1.0, 0.0]), 0.5, [0.5, 0.0], [-1.0, 0.0], 1),
        (([1.0, 0.0], [-1.0, 0.0]), 2.5, [-0.5, 0.0], [1.0, 0.0], 1),
        // Outward at 45 degrees: reflected onto the side of a square.
        (([1.0, 0.0], [1.0, 1.0]), 0.5, [0.5, 0.5], [-1.0, 1.0], 1),
    ];
    for (start, time, position, velocity, collisions) in known {
        let (end, counted, _) = at(start, time);
        assert!(max_difference(end.position, position) < 1e-14, "{start:?}: {end:?}");
        assert!(max_difference(end.velocity, velocity) < 1e-14, "{start:?}: {end:?}");
        assert_eq!(counted, collisions, "{start:?}");
    }
    // Tangential: the limit of ever flatter chords, a slide with force m s^2 / R.
    let (end, collisions, impulse) = at(([1.0, 0.0], [0.0, -3.0]), 2.0);
    assert!(max_difference(end.position, [6.0_f64.cos(), -(6.0_f64.sin())]) < 1e-14);
    assert_eq!(collisions, 0);
    assert!((impulse / (1e-26 * 9.0 * 2.0) - 1.0).abs() < 1e-14);
    // Nearly tangential, down to one rounding: the same position, up to the flatness of the chord.
    for flatness in [1e-3, 1e-6, 1e-9, 1e-12, 1e-16, 1e-200] {
        let (near, _, near_impulse) = at(([1.0, 0.0], [-flatness, -3.0]), 2.0);
        assert!(max_difference(near.position, end.position) < 4.0 * flatness + 1e-12, "{flatness}");
        assert!((near_impulse / impulse - 1.0).abs() < 4.0 * flatness + 1e-12, "{flatness}");
    }
}

#[test]
fn number_of_frames_changes_no_bit() {
    let config = GasConfig { duration_s: positive(0.1), ..GasConfig::default() };
    let mut at_once = gas(&config, 14);
    advance(&mut at_once, Target::Time(0.1));
    for frames in [3_u32, 10, 77] {
        let mut often = gas(&config, 14);
        let mut collisions = 0;
        let mut impulse = 0.0;
        for index in 1..=frames {
            advance(&mut often, Target::Time(0.1 * (f64::from(index) / f64::from(frames))));
            collisions += channel::<GasCollisions>(&often).wall_collisions_since_last_frame;
            impulse += channel::<GasPressure>(&often).wall_impulse_n_s;
        }
        assert_eq!(particles(&often), particles(&at_once));
        let (often, once) = (channel::<GasPressure>(&often), channel::<GasPressure>(&at_once));
        assert_eq!(often.measured_since_start_n_per_m, once.measured_since_start_n_per_m);
        assert_eq!(collisions, channel::<GasCollisions>(&at_once).wall_collisions);
        // The windows cover the run without gaps: the sum of their impulses is the total, up to rounding.
        assert!((impulse / once.wall_impulse_n_s - 1.0).abs() < 1e-13);
    }
}

#[test]
fn center_shifts_the_positions_and_nothing_else() {
    let center = [12.5, -3.25];
    let at_origin = GasConfig::default();
    let elsewhere = GasConfig {
        center_m: center.map(|axis| Finite::new(axis).unwrap()),
        ..GasConfig::default()
    };
    let (mut a, mut b) = (gas(&at_origin, 3), gas(&elsewhere, 3));
    advance(&mut a, Target::Time(0.1));
    advance(&mut b, Target::Time(0.1));
    for (here, there) in particles(&a).iter().zip(particles(&b)) {
        let shifted = [0, 1].map(|axis| there.position[axis] - center[axis]);
        // A sum with 12.5 keeps 50 bits of a position below 1.
        assert!(max_difference(here.position, shifted) <= 2e-15);
        assert_eq!(here.velocity, there.velocity);
    }
    assert_eq!(channel::<GasCollisions>(&a), channel::<GasCollisions>(&b));
    assert_eq!(channel::<GasInvariants>(&a), channel::<GasInvariants>(&b));
}
