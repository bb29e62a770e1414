//! Promise: no run starts with overlapping discs or discs outside the box; what can't be placed is refused with the next step.
//!
//! Setup: random and lattice starts with equal and mixed radii, judged over all pairs; given starts that are wrong.
//! Tolerance: touching is no overlap, up to 1e-12 of the radii for rounded decimals.

use crate::scene::{SEED, discs, equal, frame, given, positive, prepared};
use kinetoscope_manifest::model::{DemConfig, DiscRadius, Placement};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::DemEnergy;
use kinetoscope_recording::frame::Level;
use std::num::NonZeroU32;

fn refusal(config: &DemConfig) -> String {
    Dem::prepare(config, SEED, false).expect_err("refused").0
}

fn crowd(count: u32, placement: Placement, radius: DiscRadius) -> DemConfig {
    DemConfig {
        discs: NonZeroU32::new(count).expect("not zero"),
        radius_m: radius,
        placement,
        ..DemConfig::default()
    }
}

#[test]
fn nothing_overlaps_and_all_stand_inside() {
    let mixed = DiscRadius::Uniform { min: positive(3e-4), max: positive(6e-4) };
    for placement in [Placement::Random, Placement::Lattice] {
        for radius in [equal(5e-4), mixed] {
            let state = discs(&prepared(&crowd(800, placement.clone(), radius)));
            assert_eq!(state.len(), 800);
            for (index, disc) in state.iter().enumerate() {
                for axis in 0..2 {
                    assert!(disc.position[axis] >= disc.radius);
                    assert!(disc.position[axis] <= 0.04 - disc.radius);
                }
                for other in &state[index + 1..] {
                    let apart = [0, 1].map(|axis| disc.position[axis] - other.position[axis]);
                    let reach = (disc.radius + other.radius) * (1.0 - 1e-12);
                    assert!(apart[0] * apart[0] + apart[1] * apart[1] >= reach * reach);
                }
            }
        }
    }
}

#[test]
fn the_ledger_begins_with_no_residual_and_the_facts_are_told() {
    let start = frame(&prepared(&DemConfig::default()));
    let energy: DemEnergy = start.get().expect("energy");
    assert_eq!((energy.residual_j, energy.dissipated_j, energy.elastic_j), (0.0, 0.0, 0.0));
    let facts: Vec<&str> = start
        .log_lines()
        .iter()
        .filter(|line| line.level == Level::Info)
        .map(|line| line.text.as_str())
        .collect();
    // N_t = 20 at zeta = 0.21545: 20/sqrt(2)/sqrt(1 - zeta^2) = 14.48 steps a pair, 20.48 a wall.
    for word in
        ["20 discs placed at random", "14.5 steps with each other, 20.5 with a wall", "c = "]
    {
        assert!(facts.iter().any(|fact| fact.contains(word)), "no {word:?} in {facts:?}");
    }
}

#[test]
fn too_many_discs_are_refused() {
    // 1300 cover 64 % of the box: more than can be placed at random, less than the lattice holds.
    assert!(refusal(&crowd(1300, Placement::Random, equal(5e-4))).contains("lattice"));
    assert_eq!(discs(&prepared(&crowd(1300, Placement::Lattice, equal(5e-4)))).len(), 1300);
    assert!(refusal(&crowd(1700, Placement::Lattice, equal(5e-4))).contains("fewer discs"));
    assert!(refusal(&crowd(1, Placement::Random, equal(0.021))).contains("no room"));
}

#[test]
fn wrong_given_starts_are_refused_and_touching_ones_are_not() {
    let still = [0.0, 0.0];
    let start = |places: &[[f64; 2]]| {
        let places: Vec<_> = places.iter().map(|&place| (place, still)).collect();
        given(DemConfig::default(), &places)
    };
    assert!(refusal(&start(&[[0.01, 0.01], [0.0109, 0.01]])).contains("Discs 0 and 1"));
    assert!(refusal(&start(&[[0.01, 0.01], [0.0399, 0.01]])).contains("Disc 1"));
    assert!(refusal(&start(&[[0.01, 0.0004]])).contains("Disc 0"));
    let mismatch = DemConfig {
        discs: NonZeroU32::new(3).expect("not zero"),
        ..start(&[[0.01, 0.01], [0.02, 0.01]])
    };
    assert!(refusal(&mismatch).contains("discs = 3"));
    let touching = start(&[[0.0123, 0.0005], [0.0133, 0.0005], [0.0143, 0.0005]]);
    assert_eq!(discs(&prepared(&touching)).len(), 3);
}
