//! Law: a dilute gas leaves through a gap of the width w at the rate n (w - d) <|v|>/π, with the density n, the diameter d of a disc and its mean speed.
//!
//! Source: kinetic theory of effusion in two dimensions: the flux on a line is n <|v|>/π, and a disc passes a gap if its center passes one that is narrower by
//! its diameter. Discs that have passed the narrowest line do not return: an obstacle behind it is convex and turns them further away.
//! Setup: obstacles that touch are a partition, in which one is missing; 100 discs at random on one side, 300 starts. N/2 (1 - exp(-2 k t)) discs
//! are on the other side after a time t, k = (w - d) <|v|>/(π A) with the area A that centers have on a side, averaged over the speeds of the discs.
//! Range and tolerance: 3 standard errors of a binomial number, 7 %, and the density at a wall, higher by 2 φ, 0.8 %; discs collide rarely, and exchange their
//! speeds, which is 1 % here.
//! Control: the width without the diameter, and a gap that is closed.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::runs::{advance_to_time, disc_states, distance, given, prepare, with_obstacles};
use kinetoscope_manifest::model::PackingConfig;
use kinetoscope_manifest::quantity::Positive;
use std::f64::consts::{PI, TAU};

const RADIUS: f64 = 0.1;
const OBSTACLE: f64 = 0.5;
const DISCS: usize = 100;
const STARTS: u64 = 300;
const TIME: f64 = 160.0;

/// Obstacles from the bottom to the top of the box of 40 x 40; the 21st is missing unless the gap is closed.
fn partition(is_closed: bool) -> Vec<[f64; 2]> {
    let all = (0..=40).map(|index| [0.0, f64::from(index) - 20.0]);
    all.filter(|[_, y]| is_closed || *y != 0.0).collect()
}

/// Half of the thickness of the partition at a height of the center of a disc.
fn half_thickness(partition: &[[f64; 2]], y: f64) -> f64 {
    let contact = OBSTACLE + RADIUS;
    let chord = |center: &[f64; 2]| contact * contact - (y - center[1]) * (y - center[1]);
    partition.iter().map(chord).fold(0.0, f64::max).sqrt()
}

/// Discs on the left side, with Maxwell's velocities, by a linear congruential generator (Knuth, The Art of Computer Programming 2, section 3.3.4).
fn start(partition: &[[f64; 2]], seed: u64) -> Vec<[f64; 4]> {
    let mut state = seed;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..10).for_each(|_| _ = random());
    let mut discs: Vec<[f64; 4]> = Vec::new();
    let half = 20.0 - RADIUS;
    while discs.len() < DISCS {
        let place = [-half * random(), half * (2.0 * random() - 1.0)];
        let is_free = partition.iter().all(|peg| distance(*peg, place) > OBSTACLE + RADIUS)
            && discs.iter().all(|[x, y, ..]| distance([*x, *y], place) > 2.0 * RADIUS);
        if is_free {
            let (radius, angle) = ((-2.0 * (1.0 - random()).ln()).sqrt(), TAU * random());
            discs.push([place[0], place[1], radius * angle.cos(), radius * angle.sin()]);
        }
    }
    discs
}

#[test]
fn rate_is_that_of_kinetic_theory_for_the_width_less_the_diameter() {
    let open = partition(false);
    let (points, half) = (100_000, 20.0 - RADIUS);
    let area: f64 = (0..points)
        .map(|index| {
            let y = half * (2.0 * (f64::from(index) + 0.5) / f64::from(points) - 1.0);
            (half - half_thickness(&open, y)) * 2.0 * half / f64::from(points)
        })
        .sum();
    let (mut counted, mut expected, mut control) = (0.0, 0.0, 0.0);
    for seed in 0..STARTS {
        let discs = start(&open, seed);
        for [_, _, vx, vy] in &discs {
            let passed = |width: f64| {
                let rate = width * (vx * vx + vy * vy).sqrt() / (PI * area);
                0.5 * (1.0 - (-2.0 * rate * TIME).exp())
            };
            expected += passed(1.0 - 2.0 * RADIUS);
            control += passed(1.0);
        }
        let config = PackingConfig { radius: Positive::literal(RADIUS), ..given(&discs) };
        let mut gas = prepare(&with_obstacles(config.clone(), &open, OBSTACLE), seed, 0);
        advance_to_time(&mut gas, TIME);
        let right = |discs: &[crate::runs::DiscState]| {
            discs.iter().filter(|disc| disc.position[0] > 0.0).count() as f64
        };
        counted += right(&disc_states(&gas));
        if seed < 3 {
            let mut closed = prepare(&with_obstacles(config, &partition(true), OBSTACLE), seed, 0);
            advance_to_time(&mut closed, 5.0 * TIME);
            assert_eq!(right(&disc_states(&closed)), 0.0, "the partition is closed");
        }
    }
    let all = STARTS as f64 * DISCS as f64;
    let error = (expected * (1.0 - expected / all)).sqrt();
    let allowed = 3.0 * error + 0.018 * expected;
    println!(
        "{counted} of {all} left, kinetic theory {expected:.1} ± {error:.1}, control {control:.1}"
    );
    assert!((counted - expected).abs() < allowed, "{counted} {expected}");
    assert!((counted - control).abs() > allowed, "control: {counted} {control}");
}
