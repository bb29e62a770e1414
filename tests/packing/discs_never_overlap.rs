//! Law: |x_i - x_j| >= s for every pair, |x| <= lx/2 - r and |y| <= ly/2 - r for every disc, at every frame.
//! Source: packing document ("región efectiva", `tcol`): hard discs in a rectangle.
//! Setup: dilute to dense, elastic and not, frames by events and by times that have nothing to do with events.
//! Tolerance: 1e-12 r, some ten grains of a coordinate in these boxes (side / 2 < 64, grain 7e-15).
//! Control: one disc of a frame put 1e-9 r nearer to its closest neighbor, or 1e-9 r beyond a wall.

// A test judges within tolerances: no bit of a run depends on it.
#![allow(clippy::disallowed_methods)]

use crate::runs::{
    Seen, advance_to_count, advance_to_time, at_fraction, distance, look, prepare, with_restitution,
};
use kinetoscope_manifest::model::{PackingConfig, PackingPlacement};

const TOLERANCE: f64 = 1e-12;

/// Deepest overlap of two discs or of a disc and a wall, over the radius; below zero if nothing touches.
fn deepest_overlap(config: &PackingConfig, discs: &[Seen]) -> f64 {
    let half = [0.5 * config.width.get(), 0.5 * config.height.get()];
    let mut deepest = f64::NEG_INFINITY;
    for (index, disc) in discs.iter().enumerate() {
        for (place, half) in disc.position.iter().zip(half) {
            deepest = deepest.max(place.abs() + disc.radius - half);
        }
        for other in &discs[..index] {
            deepest = deepest.max(2.0 * disc.radius - distance(disc.position, other.position));
        }
    }
    deepest / config.radius.get()
}

#[test]
fn nobody_overlaps_at_any_frame() {
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
        let mut deepest = deepest_overlap(&config, &look(&packing));
        for frame in 1..=100 {
            advance_to_count(&mut packing, frame * 400);
            deepest = deepest.max(deepest_overlap(&config, &look(&packing)));
        }
        let start = kinetoscope_physics::model::Model::time(&packing);
        for frame in 1..=100 {
            advance_to_time(&mut packing, start * (1.0 + f64::from(frame) * 0.0037));
            deepest = deepest.max(deepest_overlap(&config, &look(&packing)));
        }
        println!("{} discs: deepest overlap {deepest:e} r", config.discs);
        assert!(deepest < TOLERANCE);
    }
}

#[test]
fn the_judge_sees_an_overlap_of_a_billionth() {
    let config = at_fraction(200, 0.3);
    let mut packing = prepare(&config, 3, 0);
    advance_to_count(&mut packing, 1000);
    let discs = look(&packing);

    let mut beyond_wall = discs.clone();
    beyond_wall[7].position[1] = 0.5 * config.height.get() - 1.0 + 1e-9;
    assert!(deepest_overlap(&config, &beyond_wall) > TOLERANCE);

    let mut too_near = discs;
    let from = too_near[0].position;
    too_near[1].position = [from[0] + 2.0 - 1e-9, from[1]];
    assert!(deepest_overlap(&config, &too_near) > TOLERANCE);
}
