//! Law: the angle about the Sun since the start, counted through whole turns, is continuous, and grows into the direction of
//! the motion however the orbit lies: angle + 2 pi turns changes by what lies between two positions.
//!
//! Source: the definition. Setup: zigzag ways over both half axes, forwards and back, onto the axes themselves with zeros of
//! both signs; whole runs of a tilted and of a retrograde orbit.
//! Tolerance: 1e-14, the rounding of atan2. Control: turns left out are seen as a jump.

use crate::run::{advance, document, finished, given, look, prepare};
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator};
use kinetoscope_physics::orbit::motion::State;
use kinetoscope_physics::orbit::orbital_plane::OrbitalPlane;
use std::f64::consts::{PI, TAU};

const PLANE_START: State = State { position: [2.0, 0.0, 0.0], velocity: [0.0, 0.01, 0.0] };

#[test]
fn the_angle_follows_every_way_forwards_and_back() {
    let plane = OrbitalPlane::of(PLANE_START);
    // Angles in tenths of pi, less than half a turn apart.
    let way = [
        0, 4, 8, 11, 9, 12, 15, 19, 21, 18, 24, 29, 33, 28, 22, 18, 13, 8, 11, 8, 3, -3, -7, -12,
        -8, 1,
    ];
    let place = |tenths: i32| {
        let angle = PI / 10.0 * f64::from(tenths);
        [0.7 * libm::cos(angle), 0.7 * libm::sin(angle), 0.0]
    };
    let (mut turns, mut jumps) = (0, 0);
    for pair in way.windows(2) {
        let step = plane.turns_between(place(pair[0]), place(pair[1]));
        turns += step;
        jumps += i32::from(step != 0);
        let angle = plane.angle(place(pair[1])) + TAU * turns as f64;
        assert!((angle - PI / 10.0 * f64::from(pair[1])).abs() < 1e-14, "{pair:?}: {angle}");
    }
    assert!(jumps > 5, "control: without the turns the angle jumps");
}

#[test]
fn the_branch_itself_belongs_to_the_first_half_whatever_the_sign_of_zero() {
    let plane = OrbitalPlane::of(PLANE_START);
    let [above, below] = [[-1.0, 0.5, 0.0], [-1.0, -0.5, 0.0]];
    for zero in [0.0, -0.0] {
        let branch = [-1.0, zero, zero];
        assert_eq!(plane.angle(branch), PI);
        assert_eq!(plane.turns_between(above, branch), 0);
        assert_eq!(plane.turns_between(branch, below), 1);
        assert_eq!(plane.turns_between(below, branch), -1);
        assert_eq!(plane.turns_between(branch, above), 0);
    }
    assert_eq!(plane.turns_between(above, below), 1);
    assert_eq!(plane.turns_between(below, above), -1);
}

#[test]
fn tilted_and_retrograde_orbits_count_forwards() {
    let speed = 0.0172;
    for velocity in [
        [0.0, speed, 0.0],
        [0.0, -speed, 0.0],
        [0.0, 0.0, speed],
        [0.0, -0.6 * speed, -0.8 * speed],
    ] {
        for integrator in [OrbitIntegrator::Yoshida4, OrbitIntegrator::Kepler] {
            let config = OrbitConfig {
                start: given([1.0, 0.0, 0.0], velocity),
                ..document(integrator, 1.0 / 4.0, 10.0 * 365.25)
            };
            let seen = look(&finished(&config)).orbit;
            // A circle at 1 AU takes 365.257 days; 0.0172 AU/day is 1.2e-4 short of its speed.
            assert!((seen.revolutions - 10.0).abs() < 0.01, "{velocity:?}: {}", seen.revolutions);
            assert!(seen.phase_error_rad.abs() < 1e-6);
        }
    }
}

/// From a start that flies in, e = 0.9, more than half a revolution lies within half a period: the exact angle and the one in
/// the plane differ there by a whole turn.
#[test]
fn an_eccentric_orbit_is_followed_past_its_perihelion() {
    let config = OrbitConfig {
        start: given([1.0, 0.0, 0.0], [-0.012, 0.007, 0.0]),
        ..document(OrbitIntegrator::Kepler, 0.5, 1000.0)
    };
    let mut run = prepare(&config);
    let mut last = 0.0;
    for count in 1..=2000 {
        advance(&mut run, count);
        let seen = look(&run).orbit;
        assert!(seen.phase_error_rad.abs() < 1e-9, "step {count}: {}", seen.phase_error_rad);
        assert!(seen.revolutions > last && seen.revolutions < last + 0.5, "step {count}");
        last = seen.revolutions;
    }
    assert!(last > 3.0, "{last}");
}
