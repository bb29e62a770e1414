//! Law: x(t) = fold(x0 + v t) for a single disc between walls without noise, at any time; fold is the triangle wave of
//! period 4 a between -a and a, a = lx/2 - r.
//!
//! Source: method of images for a rectangular billiard.
//! Setup: default box 40 x 40, r = 1, a = 19; frames at times that are not events, up to 100,000.
//! Tolerance: 1e-10. The path v t of 75,000 has a rounding of 1.5e-11 in this test's own arithmetic; the time and
//! position of a wall collision are rounded by about 5e-14, which adds up to 3e-12 over 3500 collisions with random
//! signs.
//! Control: a path with a radius that differs by 1e-9 (another a) is rejected.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods)]

use crate::runs::{advance_to_time, disc_states, given, prepare};
use kinetoscope_physics::model::Model;

const TOLERANCE: f64 = 1e-10;

fn fold(unfolded: f64, reach: f64) -> f64 {
    let phase = (unfolded + reach).rem_euclid(4.0 * reach);
    if phase < 2.0 * reach { phase - reach } else { 3.0 * reach - phase }
}

#[test]
fn disc_follows_its_unfolded_path() {
    let start = [3.0, -7.0, 0.7548776662466927, 0.5698402909980532];
    let mut packing = prepare(&given(&[start]), 0, 0);
    let (mut error, mut error_of_control) = (0.0_f64, 0.0_f64);
    for frame in 1..=1000 {
        let time = f64::from(frame) * 99.937;
        advance_to_time(&mut packing, time);
        assert_eq!(packing.time(), time);
        let position = disc_states(&packing)[0].position;
        for axis in 0..2 {
            let path = start[axis] + start[axis + 2] * time;
            error = error.max((position[axis] - fold(path, 19.0)).abs());
            error_of_control =
                error_of_control.max((position[axis] - fold(path, 19.0 + 1e-9)).abs());
        }
    }
    println!("after {} wall collisions: largest error {error:e}", packing.count());
    assert!(packing.count() > 3000);
    assert!(error < TOLERANCE);
    assert!(error_of_control > TOLERANCE);
}
