//! Law: a disc released on an incline rolls if mu > tan(theta)/3, with v = r |w| = (2/3) g sin(theta) t. Otherwise it
//! slides, with v = g (sin(theta) - mu cos(theta)) t and r |w| = 2 mu g cos(theta) t, and friction dissipates m mu g
//! cos(theta) times the slip.
//!
//! Source: m a = m g sin(theta) - F, I alpha = F r with I = m r^2/2, and Coulomb's F <= mu N.
//! Setup: gravity tilted by 30 degrees over a horizontal floor, a disc in contact with it, 0.3 s; k = 1e6 N/m, e = 0.5,
//! N_t = 20.
//! Tolerance: 1e-4; the disc starts without overlap and bounces by micrometers at first.
//! Control: a friction coefficient larger by 1e-3 is rejected.

use crate::scene::{
    energy, frame, given, gravity, non_negative, positive, prepared, run_to, spring, time_step,
};
use kinetoscope_manifest::model::DemConfig;

const G: f64 = 9.81;
const RADIUS: f64 = 5e-4;
const TIME: f64 = 0.3;
const ANGLE: f64 = std::f64::consts::FRAC_PI_6;

/// Speed along the incline, surface speed r |w|, and energy dissipated by friction, at the end.
fn measured(friction: f64) -> [f64; 3] {
    let config = DemConfig {
        width_m: positive(1.0),
        gravity_m_per_s2: gravity(G * libm::sin(ANGLE), -G * libm::cos(ANGLE)),
        elasticity: spring(1e6),
        friction: non_negative(friction),
        ..DemConfig::default()
    };
    let mut model = prepared(&given(config, &[([0.01, RADIUS], [0.0, 0.0])]));
    let steps = (TIME / time_step(&model)) as u64;
    run_to(&mut model, steps);
    let frame = frame(&model);
    [frame.state()[2], RADIUS * frame.state()[7].abs(), energy(&model).friction_j]
}

fn expected(friction: f64) -> [f64; 3] {
    let (sine, cosine) = (libm::sin(ANGLE), libm::cos(ANGLE));
    if friction > sine / cosine / 3.0 {
        let speed = 2.0 / 3.0 * G * sine * TIME;
        return [speed, speed, 0.0];
    }
    let speed = G * (sine - friction * cosine) * TIME;
    let surface = 2.0 * friction * G * cosine * TIME;
    [speed, surface, 1e-3 * friction * G * cosine * 0.5 * (speed - surface) * TIME]
}

/// Largest error over the speed, and over the loss of potential energy.
fn relative_error(found: [f64; 3], expected: [f64; 3]) -> f64 {
    let fall = 0.5 * 1e-3 * G * libm::sin(ANGLE) * expected[0] * TIME;
    [0, 1, 2]
        .map(|index| {
            let scale = if index == 2 { fall } else { expected[0] };
            (found[index] - expected[index]).abs() / scale
        })
        .into_iter()
        .fold(0.0, |max, error| if error > max { error } else { max })
}

#[test]
fn disc_slides_below_a_third_of_the_tangent_and_rolls_above() {
    for friction in [0.05, 0.1, 0.18, 0.21, 0.5] {
        let (found, expected) = (measured(friction), expected(friction));
        let error = relative_error(found, expected);
        println!("mu = {friction}: {found:?}, expected {expected:?}, error {error:.1e}");
        assert!(error < 1e-4, "mu = {friction}");
    }
}

#[test]
fn control_different_friction_is_rejected() {
    assert!(relative_error(measured(0.1001), expected(0.1)) > 1e-4);
    assert!(relative_error(measured(0.18), expected(0.21)) > 1e-4);
}
