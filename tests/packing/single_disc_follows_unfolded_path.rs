//! Law: a single disc between walls without noise is where its unfolded straight path, folded back, says: for ever.
//! x(t) = fold(x0 + v t), fold the triangle wave of period 4 a between -a and a, a = lx/2 - r.
//! Source: method of images for a rectangular billiard.
//! Setup: default box 40 x 40, r = 1, a = 19; frames at times that are no events, up to 100,000.
//! Tolerance: 1e-10. The path v t of 75,000 has a grain of 1.5e-11 in this test's own arithmetic; a wall's time and place
//! are rounded by some 5e-14 and add up along 3500 walls to 3e-12 at random sign.
//! Control: a path of another radius (another a) by 1e-9 is rejected.

// A test judges within tolerances: no bit of a run depends on it.
#![allow(clippy::disallowed_methods)]

use crate::runs::{advance_to_time, given, look, prepare};
use kinetoscope_physics::model::Model;

const TOLERANCE: f64 = 1e-10;

fn fold(unfolded: f64, reach: f64) -> f64 {
    let phase = (unfolded + reach).rem_euclid(4.0 * reach);
    if phase < 2.0 * reach { phase - reach } else { 3.0 * reach - phase }
}

#[test]
fn the_disc_is_where_its_unfolded_path_says() {
    let start = [3.0, -7.0, 0.7548776662466927, 0.5698402909980532];
    let mut packing = prepare(&given(&[start]), 0, 0);
    let (mut error, mut error_of_control) = (0.0_f64, 0.0_f64);
    for frame in 1..=1000 {
        let time = f64::from(frame) * 99.937;
        advance_to_time(&mut packing, time);
        assert_eq!(packing.time(), time);
        let seen = look(&packing)[0].position;
        for axis in 0..2 {
            let path = start[axis] + start[axis + 2] * time;
            error = error.max((seen[axis] - fold(path, 19.0)).abs());
            error_of_control = error_of_control.max((seen[axis] - fold(path, 19.0 + 1e-9)).abs());
        }
    }
    println!("after {} walls: largest error {error:e}", packing.count());
    assert!(packing.count() > 3000);
    assert!(error < TOLERANCE);
    assert!(error_of_control > TOLERANCE);
}
