//! Law: a pair collision changes the normal part g of the relative velocity to -alpha g, and conserves its tangential
//! part and the momentum; it takes place when the distance equals the diameter.
//!
//! Source: packing exercise, `colisiona` and `tcol`; closed form.
//! Setup: two approaching discs of radius 1, head-on and with an offset b: they collide when their distance along the
//! relative velocity is sqrt(s^2 - b^2).
//! Tolerance: 1e-13, for about a hundred roundings of numbers of order 1.
//! Control: the outcome of a restitution that differs by 1e-9 is rejected.

use crate::runs::{
    DiscState, advance_to_count, disc_states, given, message, prepare, with_restitution,
};
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::{PackingCollisions, PackingPressure};

const TOLERANCE: f64 = 1e-13;

struct Parts {
    normal: f64,
    tangential: f64,
    momentum: [f64; 2],
}

/// Relative velocity along and across the line of centers at contact, and the momentum.
fn parts(contact: [f64; 2], discs: &[DiscState]) -> Parts {
    let [first, second] = [discs[0].velocity, discs[1].velocity];
    let relative = [second[0] - first[0], second[1] - first[1]];
    let normal = [contact[0] / 2.0, contact[1] / 2.0];
    Parts {
        normal: relative[0] * normal[0] + relative[1] * normal[1],
        tangential: relative[1] * normal[0] - relative[0] * normal[1],
        momentum: [first[0] + second[0], first[1] + second[1]],
    }
}

fn obeys(before: &Parts, after: &Parts, restitution: f64) -> bool {
    let errors = [
        after.normal + restitution * before.normal,
        after.tangential - before.tangential,
        after.momentum[0] - before.momentum[0],
        after.momentum[1] - before.momentum[1],
    ];
    errors.iter().all(|error| error.abs() < TOLERANCE)
}

#[test]
fn outcome_equals_the_closed_form() {
    for restitution in [1.0, 0.9, 0.5, 0.001] {
        for offset in [0.0, 0.3, -1.2, 1.999] {
            let (first, second) = ([-5.0, 0.0, 1.5, 0.25], [4.0, offset, -0.5, 0.25]);
            let config = with_restitution(given(&[first, second]), restitution);
            let mut packing = prepare(&config, 0, 0);
            let along = (4.0 - offset * offset).sqrt();
            let contact = [along, offset];
            let before = parts(contact, &disc_states(&packing));

            advance_to_count(&mut packing, 1);

            // The discs cover 9 - along at the relative speed 2.
            let expected = (9.0 - along) / 2.0;
            // At a grazing contact, the time is as uncertain as the square root: d(along) = d(s^2) / (2 along).
            let tolerance = TOLERANCE / along;
            assert!((packing.time() - expected).abs() < tolerance, "offset {offset}");
            let after = parts(contact, &disc_states(&packing));
            assert!(obeys(&before, &after, restitution), "offset {offset}, alpha {restitution}");
            assert!(!obeys(&before, &after, restitution - 1e-9 / before.normal.abs()));
            assert_eq!(message::<PackingCollisions>(&packing).pair_collisions, 1);

            // The virial is the diameter times the normal impulse (1 + alpha) |g| / 2.
            let virial = message::<PackingPressure>(&packing).collision_virial_sum;
            let expected = 2.0 * 0.5 * (1.0 + restitution) * before.normal.abs();
            assert!((virial - expected).abs() < TOLERANCE);
        }
    }
}

/// Two discs at -4 and 4 with velocities 1 and -1 in a box of 40, without noise, collide at time 3, each reaches its
/// wall, at a distance of 18, at 3 + 18, and so on every 36.
/// Tolerance: none; all times and positions are exact.
#[test]
fn head_on_pair_collides_at_exact_times() {
    let mut packing = prepare(&given(&[[-4.0, 5.0, 1.0, 0.0], [4.0, 5.0, -1.0, 0.0]]), 0, 0);
    for round in 0..1000_u32 {
        advance_to_count(&mut packing, u64::from(3 * round + 1));
        assert_eq!(packing.time(), 3.0 + 36.0 * f64::from(round));
        advance_to_count(&mut packing, u64::from(3 * round + 3));
        assert_eq!(packing.time(), 3.0 + 36.0 * f64::from(round) + 18.0);
    }
    let collisions = message::<PackingCollisions>(&packing);
    assert_eq!((collisions.pair_collisions, collisions.wall_collisions), (1000, 2000));
}

/// Discs that narrowly miss each other do not collide, and neither do discs that touch and separate or move in parallel.
#[test]
fn missing_separating_and_parallel_discs_do_not_collide() {
    let missing = given(&[[-5.0, 0.0, 1.0, 0.0], [5.0, 2.0 + 1e-12, -1.0, 0.0]]);
    let separating = given(&[[-1.0, 0.0, -1.0, 0.0], [1.0, 0.0, 1.0, 0.0]]);
    let parallel = given(&[[0.0, 1.0, 1.0, 0.0], [0.0, -1.0, 1.0, 0.0]]);
    for config in [missing, separating, parallel] {
        let mut packing = prepare(&config, 0, 0);
        advance_to_count(&mut packing, 2);
        assert_eq!(message::<PackingCollisions>(&packing).wall_collisions, 2);
    }
}

/// A disc that touches another and approaches it transfers its velocity at once.
#[test]
fn touching_discs_that_approach_collide_at_once() {
    let row = given(&[[0.0, 0.0, 1.0, 0.0], [2.0, 0.0, 0.0, 0.0], [4.0, 0.0, 0.0, 0.0]]);
    let mut packing = prepare(&row, 0, 0);
    advance_to_count(&mut packing, 2);
    assert_eq!(packing.time(), 0.0);
    let velocities: Vec<f64> = disc_states(&packing).iter().map(|disc| disc.velocity[0]).collect();
    assert_eq!(velocities, [0.0, 0.0, 1.0]);
}
