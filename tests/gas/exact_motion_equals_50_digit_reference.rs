//! Law: a particle in a circle flies chords of one length, each turned by beta = pi - 2 asin(d/R) against the last:
//! p(t) = Rot(k beta) [(b0 + s t - 2 C k) v^ - d n^], v(t) = Rot(k beta) v0.
//!
//! Source: gas document, exercise 14g1, equations (7), (9) and the mirror; circular billiard. Reference values: 50-digit arithmetic,
//! and regular polygons, whose corners are known.
//! Setup: written particles in a circle of radius 1.
//! Tolerance: 1e-9 after 1174 hits (path 1000 radii, rounding 2^-53 a radius and hit, sum below 1e-12); hit counts exact.

// Tests compare with the platform's functions; bits are not their business. References keep the digits of their source.
#![allow(clippy::disallowed_methods, clippy::excessive_precision)]

use crate::runs::{advance, apart, channel, gas, particles, positive, written};
use kinetoscope_manifest::model::GasConfig;
use kinetoscope_manifest::quantity::Finite;
use kinetoscope_physics::gas::motion::{Particle, drifted, time_to_wall};
use kinetoscope_physics::model::{Extent, Model, Target};
use kinetoscope_recording::channels::{GasCollisions, GasInvariants, GasPressure};
use std::f64::consts::PI;

type Reference = (([f64; 2], [f64; 2]), u64, [f64; 2], [f64; 2]);

/// Start, hits, place and velocity at t = 1000, R = 1, by 50-digit arithmetic.
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
fn paths_of_a_thousand_hits_agree_with_fifty_digits() {
    for (start, hits, position, velocity) in REFERENCES {
        let mut gas = gas(&written(&[start]), 1);
        assert_eq!(gas.extent(), Extent::Time(1000.0));
        advance(&mut gas, Target::Time(1000.0));
        let end = particles(&gas)[0];
        let error = apart(end.position, position).max(apart(end.velocity, velocity));
        println!("{hits} hits: error {error:e}");
        assert!(error < 1e-9);
        assert_eq!(channel::<GasCollisions>(&gas).wall, hits);
        assert_eq!(gas.count(), hits);
    }
}

/// The same path from hit to hit, with a wall that returns this share of the normal velocity: 1 is the law.
fn from_hit_to_hit(start: ([f64; 2], [f64; 2]), hits: u64, returned: f64) -> [f64; 2] {
    let mut particle = Particle { position: start.0, velocity: start.1 };
    let mut rest = 1000.0;
    for _ in 0..hits {
        let time = time_to_wall(particle, 1.0);
        rest -= time;
        let hit = drifted(particle, time).position;
        let [vx, vy] = particle.velocity;
        let square = hit[0] * hit[0] + hit[1] * hit[1];
        let outwards = (1.0 + returned) * (vx * hit[0] + vy * hit[1]) / square;
        particle =
            Particle { position: hit, velocity: [vx - outwards * hit[0], vy - outwards * hit[1]] };
    }
    drifted(particle, rest).position
}

#[test]
fn control_a_wall_that_keeps_a_billionth_fails_the_same_judge() {
    for (start, hits, position, _) in REFERENCES {
        let error = |returned| apart(from_hit_to_hit(start, hits, returned), position);
        println!("{hits} hits: mirror {:e}, lossy wall {:e}", error(1.0), error(1.0 - 1e-9));
        assert!(error(1.0) < 1e-9);
        assert!(error(1.0 - 1e-9) > 1e-9);
    }
}

#[test]
fn regular_polygons_close_after_their_corners() {
    // From (R, 0) along the first side of a regular n-gon; after j sides the particle is at corner j.
    for corners in [2_u32, 3, 4, 5, 12, 1000] {
        let angle = 2.0 * PI / f64::from(corners);
        let corner = |j: f64| [(j * angle).cos(), (j * angle).sin()];
        let side = 2.0 * (angle / 2.0).sin();
        let velocity = [(corner(1.0)[0] - 1.0) / side, corner(1.0)[1] / side];
        for sides in [0.5, 1.5, 7.25, 1000.5] {
            let mut gas = gas(&written(&[([1.0, 0.0], velocity)]), 1);
            advance(&mut gas, Target::Time(sides * side));
            let done = f64::floor(sides);
            let share = sides - done;
            let (from, to) = (corner(done), corner(done + 1.0));
            let expected = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
            let error = apart(particles(&gas)[0].position, expected);
            assert!(error < 1e-10, "{corners} corners, {sides} sides: {error:e}");
            assert_eq!(channel::<GasCollisions>(&gas).wall, done as u64);
            let sine = (angle / 2.0).sin();
            let impulse = 1e-26 * done * 2.0 * sine;
            let pressure = channel::<GasPressure>(&gas);
            assert!((pressure.wall_impulse_n_s - impulse).abs() <= 1e-12 * impulse);
        }
    }
}

#[test]
fn every_start_is_defined() {
    let at = |start, time| {
        let mut gas = gas(&written(&[start]), 1);
        advance(&mut gas, Target::Time(time));
        let hits = channel::<GasCollisions>(&gas).wall;
        (particles(&gas)[0], hits, channel::<GasPressure>(&gas).wall_impulse_n_s)
    };
    // Start, time, place, velocity, hits: each known without a formula.
    let known: [(_, f64, [f64; 2], [f64; 2], u64); 8] = [
        // At rest: inside, at the center, on the wall.
        (([0.3, 0.4], [0.0, 0.0]), 7.0, [0.3, 0.4], [0.0, 0.0], 0),
        (([0.0, 0.0], [0.0, 0.0]), 7.0, [0.0, 0.0], [0.0, 0.0], 0),
        (([0.6, 0.8], [0.0, 0.0]), 7.0, [0.6, 0.8], [0.0, 0.0], 0),
        // Radial, from the center and from elsewhere: to and fro on a diameter.
        (([0.0, 0.0], [1.0, 0.0]), 3.5, [-0.5, 0.0], [1.0, 0.0], 2),
        (([0.5, 0.0], [-2.0, 0.0]), 2.0, [0.5, 0.0], [-2.0, 0.0], 2),
        // On the wall: outwards hits at once, inwards later.
        (([1.0, 0.0], [1.0, 0.0]), 0.5, [0.5, 0.0], [-1.0, 0.0], 1),
        (([1.0, 0.0], [-1.0, 0.0]), 2.5, [-0.5, 0.0], [1.0, 0.0], 1),
        // Outwards at 45 degrees: mirrored onto the side of a square.
        (([1.0, 0.0], [1.0, 1.0]), 0.5, [0.5, 0.5], [-1.0, 1.0], 1),
    ];
    for (start, time, position, velocity, hits) in known {
        let (end, counted, _) = at(start, time);
        assert!(apart(end.position, position) < 1e-14, "{start:?}: {end:?}");
        assert!(apart(end.velocity, velocity) < 1e-14, "{start:?}: {end:?}");
        assert_eq!(counted, hits, "{start:?}");
    }
    // Along the wall: the limit of ever flatter chords, a slide with force m s^2 / R.
    let (end, hits, impulse) = at(([1.0, 0.0], [0.0, -3.0]), 2.0);
    assert!(apart(end.position, [6.0_f64.cos(), -(6.0_f64.sin())]) < 1e-14);
    assert_eq!(hits, 0);
    assert!((impulse / (1e-26 * 9.0 * 2.0) - 1.0).abs() < 1e-14);
    // And nearly along it, down to one rounding: the same place, to the chord's flatness.
    for flatness in [1e-3, 1e-6, 1e-9, 1e-12, 1e-16, 1e-200] {
        let (near, _, pushed) = at(([1.0, 0.0], [-flatness, -3.0]), 2.0);
        assert!(apart(near.position, end.position) < 4.0 * flatness + 1e-12, "{flatness}");
        assert!((pushed / impulse - 1.0).abs() < 4.0 * flatness + 1e-12, "{flatness}");
    }
}

#[test]
fn any_sequence_of_frames_gives_the_same_bits() {
    let config = GasConfig { duration_s: positive(0.1), ..GasConfig::default() };
    let mut at_once = gas(&config, 14);
    advance(&mut at_once, Target::Time(0.1));
    for frames in [3_u32, 10, 77] {
        let mut often = gas(&config, 14);
        let mut hits = 0;
        let mut impulse = 0.0;
        for index in 1..=frames {
            advance(&mut often, Target::Time(0.1 * (f64::from(index) / f64::from(frames))));
            hits += channel::<GasCollisions>(&often).wall_since_last_frame;
            impulse += channel::<GasPressure>(&often).wall_impulse_n_s;
        }
        assert_eq!(particles(&often), particles(&at_once));
        let (often, once) = (channel::<GasPressure>(&often), channel::<GasPressure>(&at_once));
        assert_eq!(often.measured_since_start_n_per_m, once.measured_since_start_n_per_m);
        assert_eq!(hits, channel::<GasCollisions>(&at_once).wall);
        // The windows tile the run: their impulses add up to rounding.
        assert!((impulse / once.wall_impulse_n_s - 1.0).abs() < 1e-13);
    }
}

#[test]
fn a_center_elsewhere_shifts_the_result_and_nothing_else() {
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
        // The sum with 12.5 keeps 50 bits of a place below 1.
        assert!(apart(here.position, shifted) <= 2e-15);
        assert_eq!(here.velocity, there.velocity);
    }
    assert_eq!(channel::<GasCollisions>(&a), channel::<GasCollisions>(&b));
    assert_eq!(channel::<GasInvariants>(&a), channel::<GasInvariants>(&b));
}
