//! Law: the angle around the Sun since the initial state, angle + 2 pi turns, is continuous and grows in the direction
//! of the motion for any orientation of the orbit.
//!
//! Source: the definition of the unwrapped angle.
//! Setup: sequences of positions that cross both half axes forward and backward, and lie on the axes with zeros of both
//! signs; whole runs of a tilted and of a retrograde orbit.
//! Tolerance: 1e-14, the rounding of atan2; otherwise stated at the assertion.
//! Control: without the turns, the angle jumps.

use crate::run::{advance, exercise, finished, given, observe, prepare};
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator};
use kinetoscope_physics::orbit::motion::State;
use kinetoscope_physics::orbit::orbital_plane::OrbitalPlane;
use std::f64::consts::{PI, TAU};

const PLANE_START: State = State { position: [2.0, 0.0, 0.0], velocity: [0.0, 0.01, 0.0] };

#[test]
fn angle_is_continuous_forward_and_backward() {
    let plane = OrbitalPlane::of(PLANE_START);
    // Angles in tenths of pi, less than half a revolution apart.
    let path = [
        0, 4, 8, 11, 9, 12, 15, 19, 21, 18, 24, 29, 33, 28, 22, 18, 13, 8, 11, 8, 3, -3, -7, -12,
        -8, 1,
    ];
    let position = |tenths: i32| {
        let angle = PI / 10.0 * f64::from(tenths);
        [0.7 * libm::cos(angle), 0.7 * libm::sin(angle), 0.0]
    };
    let (mut turns, mut jumps) = (0, 0);
    for pair in path.windows(2) {
        let step = plane.turns_between(position(pair[0]), position(pair[1]));
        turns += step;
        jumps += i32::from(step != 0);
        let angle = plane.angle(position(pair[1])) + TAU * turns as f64;
        assert!((angle - PI / 10.0 * f64::from(pair[1])).abs() < 1e-14, "{pair:?}: {angle}");
    }
    assert!(jumps > 5, "control: the angle without turns jumps");
}

#[test]
fn branch_cut_belongs_to_the_first_half_for_both_signs_of_zero() {
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
fn tilted_and_retrograde_orbits_count_positive_revolutions() {
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
                ..exercise(integrator, 1.0 / 4.0, 10.0 * 365.25)
            };
            let found = observe(&finished(&config)).orbit;
            // A circle at 1 AU takes 365.257 days; 0.0172 AU/day differs from its speed by 1.2e-4.
            assert!((found.revolutions - 10.0).abs() < 0.01, "{velocity:?}: {}", found.revolutions);
            assert!(found.phase_error_rad.abs() < 1e-6);
        }
    }
}

/// For an inbound initial state at e = 0.9, more than half a revolution takes place in less than half a period: the
/// exact angle and the one in the plane differ there by a whole revolution.
#[test]
fn eccentric_orbit_is_continuous_past_its_perihelion() {
    let config = OrbitConfig {
        start: given([1.0, 0.0, 0.0], [-0.012, 0.007, 0.0]),
        ..exercise(OrbitIntegrator::Kepler, 0.5, 1000.0)
    };
    let mut run = prepare(&config);
    let mut last = 0.0;
    for count in 1..=2000 {
        advance(&mut run, count);
        let found = observe(&run).orbit;
        assert!(found.phase_error_rad.abs() < 1e-9, "step {count}: {}", found.phase_error_rad);
        assert!(found.revolutions > last && found.revolutions < last + 0.5, "step {count}");
        last = found.revolutions;
    }
    assert!(last > 3.0, "{last}");
}
