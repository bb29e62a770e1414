//! Law: |x_i - x_j| >= s for every pair, |x| <= lx/2 - r and |y| <= ly/2 - r for every disc, in every frame.
//!
//! Source: packing exercise ("región efectiva", `tcol`): hard discs in a rectangle.
//! Setup: dilute to dense, elastic and inelastic discs; frames by events and at times that are not events.
//! Tolerance: 1e-12 r, about ten roundings of a coordinate in these boxes (side / 2 < 64, rounding 7e-15).
//! Control: one disc of a frame moved 1e-9 r closer to another disc than contact, or 1e-9 r beyond a wall, is rejected.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods)]

use crate::runs::{
    DiscState, advance_to_count, advance_to_time, at_fraction, disc_states, distance, prepare,
    with_restitution,
};
use kinetoscope_manifest::model::{PackingConfig, PackingPlacement};

const TOLERANCE: f64 = 1e-12;

/// Largest overlap of two discs or of a disc and a wall, over the radius; negative if there is no contact.
fn max_overlap(config: &PackingConfig, discs: &[DiscState]) -> f64 {
    let half = [0.5 * config.width.get(), 0.5 * config.height.get()];
    let mut max = f64::NEG_INFINITY;
    for (index, disc) in discs.iter().enumerate() {
        for (coordinate, half) in disc.position.iter().zip(half) {
            max = max.max(coordinate.abs() + disc.radius - half);
        }
        for other in &discs[..index] {
            max = max.max(2.0 * disc.radius - distance(disc.position, other.position));
        }
    }
    max / config.radius.get()
}

#[test]
fn no_disc_overlaps_in_any_frame() {
    let lattice = |discs, fraction| PackingConfig {
        placement: PackingPlacement::Lattice,
        ..at_fraction(discs, fraction)
    };
    let cases = [
        at_fraction(60, 0.02),
        at_fraction(200, 0.3),
        at_fraction(150, 0.45),
        lattice(300, 0.7),
        lattice(300, 0.8),
        with_restitution(at_fraction(200, 0.2), 0.8),
    ];
    for config in cases {
        let mut packing = prepare(&config, 3, 0);
        let mut max = max_overlap(&config, &disc_states(&packing));
        for frame in 1..=100 {
            advance_to_count(&mut packing, frame * 400);
            max = max.max(max_overlap(&config, &disc_states(&packing)));
        }
        let start = kinetoscope_physics::model::Model::time(&packing);
        for frame in 1..=100 {
            advance_to_time(&mut packing, start * (1.0 + f64::from(frame) * 0.0037));
            max = max.max(max_overlap(&config, &disc_states(&packing)));
        }
        println!("{} discs: largest overlap {max:e} r", config.discs);
        assert!(max < TOLERANCE);
    }
}

#[test]
fn control_overlap_of_a_billionth_is_rejected() {
    let config = at_fraction(200, 0.3);
    let mut packing = prepare(&config, 3, 0);
    advance_to_count(&mut packing, 1000);
    let discs = disc_states(&packing);

    let mut beyond_wall = discs.clone();
    beyond_wall[7].position[1] = 0.5 * config.height.get() - 1.0 + 1e-9;
    assert!(max_overlap(&config, &beyond_wall) > TOLERANCE);

    let mut too_close = discs;
    let from = too_close[0].position;
    too_close[1].position = [from[0] + 2.0 - 1e-9, from[1]];
    assert!(max_overlap(&config, &too_close) > TOLERANCE);
}
