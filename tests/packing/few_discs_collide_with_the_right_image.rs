//! Law: in a periodic box of any shape, elastic discs collide with the image that they touch, and conserve energy and momentum.
//!
//! Source: the reference program below, O(n^2) with nine images of each disc and no cells. It checks all pairs at
//! each event.
//! Setup: 2 to 6 discs in boxes of 10 x 10 to 400 x 10, with dilute and dense states, of which most have room for more than three
//! cells per axis but would get fewer by their number of discs. The reference copies the engine's state at every event.
//! Tolerance: 1e-9 in time and velocity, times the waiting time if it is above 1: rounding of the positions, enlarged by grazing
//! collisions. 1e-12 of the energy, and 1e-12 of overlap.
//! Control: the reference with a contact distance larger by 1e-6 is rejected.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::periodic_states::{periodic, placed};
use crate::runs::{DiscState, disc_states, exercise, prepare, squared_speed};
use kinetoscope_manifest::model::{PackingConfig, PackingPlacement};
use kinetoscope_manifest::quantity::BoxSide;
use kinetoscope_physics::model::{Model, Progress, Target};
use std::num::NonZeroU32;

type Vector = [f64; 2];

fn boxed(discs: u32, sides: [f64; 2]) -> PackingConfig {
    let config = PackingConfig {
        discs: NonZeroU32::new(discs).unwrap(),
        width: BoxSide::new(sides[0]).unwrap(),
        height: BoxSide::new(sides[1]).unwrap(),
        ..exercise()
    };
    periodic(placed(config, PackingPlacement::Lattice))
}

/// The separations of a disc and the nine images of another around the nearest one.
fn images(one: &DiscState, other: &DiscState, sides: [f64; 2], time: f64) -> Vec<[f64; 2]> {
    let nearest = [0, 1].map(|axis| {
        let apart = other.position[axis] - one.position[axis];
        let apart = apart + (other.velocity[axis] - one.velocity[axis]) * time;
        apart - sides[axis] * (apart / sides[axis]).round()
    });
    let shifts = [-1.0, 0.0, 1.0];
    let shifted = |x: f64| shifts.map(|y| [nearest[0] + x * sides[0], nearest[1] + y * sides[1]]);
    shifts.into_iter().flat_map(shifted).collect()
}

/// Time until the next collision, and the velocities after it, from all pairs and their images. Time is divided into slices in which
/// no separation changes by a quarter of the box.
fn next_collision(discs: &[DiscState], sides: [f64; 2], radius_error: f64) -> (f64, Vec<Vector>) {
    let fastest = energy(discs).sqrt() * 2.0;
    let slice = 0.25 * sides[0].min(sides[1]) / fastest;
    let velocities: Vec<Vector> = discs.iter().map(|disc| disc.velocity).collect();
    for start in (0..1_000_000).map(|number| f64::from(number) * slice) {
        let mut earliest = (start + slice, None);
        for second in 0..discs.len() {
            for first in 0..second {
                let (one, other) = (&discs[first], &discs[second]);
                let g = [0, 1].map(|axis| other.velocity[axis] - one.velocity[axis]);
                for r in images(one, other, sides, start) {
                    let (a, b) = (squared_speed(g), r[0] * g[0] + r[1] * g[1]);
                    let c = squared_speed(r) - (one.radius + other.radius + radius_error).powi(2);
                    let discriminant = b * b - a * c;
                    let time = start - (b + discriminant.sqrt()) / a;
                    // A pair that has just collided parts: b > 0.
                    if b < 0.0 && discriminant >= 0.0 && time < earliest.0 {
                        let wait = time - start;
                        let contact = [r[0] + g[0] * wait, r[1] + g[1] * wait];
                        earliest = (time, Some((first, second, contact, g)));
                    }
                }
            }
        }
        if let (time, Some((first, second, r, g))) = earliest {
            let factor = (r[0] * g[0] + r[1] * g[1]) / squared_speed(r);
            let mut after = velocities;
            for (axis, along) in r.into_iter().enumerate() {
                after[first][axis] += factor * along;
                after[second][axis] -= factor * along;
            }
            return (time, after);
        }
    }
    panic!("no collision");
}

fn max_overlap(discs: &[DiscState], sides: [f64; 2]) -> f64 {
    let mut max = f64::NEG_INFINITY;
    for (index, one) in discs.iter().enumerate() {
        for other in &discs[..index] {
            for r in images(one, other, sides, 0.0) {
                max = max.max(one.radius + other.radius - squared_speed(r).sqrt());
            }
        }
    }
    max
}

fn energy(discs: &[DiscState]) -> f64 {
    discs.iter().map(|disc| squared_speed(disc.velocity)).sum()
}

/// Advances by one collision. A fault fails the test.
fn advance(packing: &mut kinetoscope_physics::packing::Packing, count: u64) {
    assert_eq!(packing.advance(Target::Count(count), u64::MAX), Ok(Progress::Reached));
}

/// Number of collisions that agree with the reference, in this many.
fn agreeing_collisions(config: &PackingConfig, seed: u64, radius_error: f64, count: u64) -> u64 {
    let sides = [config.width.get(), config.height.get()];
    let mut packing = prepare(config, seed, 0);
    (1..=count)
        .filter(|&event| {
            let (start, before) = (packing.time(), disc_states(&packing));
            let (wait, velocities) = next_collision(&before, sides, radius_error);
            advance(&mut packing, event);
            let after = disc_states(&packing);
            let mut error = (packing.time() - start - wait).abs();
            for (disc, velocity) in after.iter().zip(velocities) {
                for (found, expected) in disc.velocity.into_iter().zip(velocity) {
                    error = error.max((found - expected).abs());
                }
            }
            error < 1e-9 * (1.0 + wait)
        })
        .count() as u64
}

const BOXES: [[f64; 2]; 6] =
    [[12.0, 10.0], [10.0, 10.0], [20.0, 20.0], [40.0, 40.0], [30.0, 10.0], [200.0, 10.0]];

#[test]
fn few_periodic_discs_agree_with_the_reference() {
    for discs in 2..=4 {
        for sides in BOXES {
            let config = boxed(discs, sides);
            let agreeing = agreeing_collisions(&config, 5, 0.0, 60);
            assert_eq!(agreeing, 60, "{discs} discs in {sides:?}");
        }
    }
    // Control.
    assert!(agreeing_collisions(&boxed(3, [10.0, 10.0]), 5, 1e-6, 60) < 60);
}

#[test]
fn periodic_discs_in_boxes_of_any_shape_conserve_energy_and_never_overlap() {
    let few = (2..=6).flat_map(|discs| BOXES.map(|sides| (discs, sides)));
    let elongated =
        [(40, [200.0, 10.0]), (100, [400.0, 10.0]), (20, [100.0, 10.0]), (30, [100.0, 12.0])];
    for (discs, sides) in few.chain(elongated) {
        for seed in 1..=2 {
            let config = boxed(discs, sides);
            let mut packing = prepare(&config, seed, 0);
            let initial = energy(&disc_states(&packing));
            for frame in 1..=4 {
                advance(&mut packing, 20 * frame * u64::from(discs));
                let states = disc_states(&packing);
                let drift = energy(&states) / initial - 1.0;
                assert!(drift.abs() < 1e-12, "{discs} discs in {sides:?}: {drift:e}");
                let overlap = max_overlap(&states, sides);
                assert!(overlap < 1e-12, "{discs} discs in {sides:?}: {overlap:e}");
            }
        }
    }
}
