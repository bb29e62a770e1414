//! Guarantee: initial states are inside the box and without overlap at any density. Those that cannot be built are
//! rejected with a remedy, the first frame logs the method of placement, and seeds and replicates are reproducible and
//! different.
//!
//! Source: packing exercise, input limits; capacity of hexagonal rows by hand where stated.
//! Setup: lattices, random placement and given states.
//! Tolerance: 1e-12 of the radius for overlaps.
//! Control: given states with an overlap, a disc outside, or a wrong number of discs are rejected.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::runs::{
    DiscState, advance_to_count, at_fraction, disc_states, distance, given, observe, prepare,
};
use kinetoscope_manifest::model::{PackingConfig, PackingPlacement};
use kinetoscope_manifest::quantity::{BoxSide, NonNegative, Positive};
use kinetoscope_physics::model::{Model, SetupError};
use kinetoscope_physics::packing::Packing;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::scenery::Wall;
use std::num::NonZeroU32;

/// Message of the rejection.
fn rejection(config: &PackingConfig) -> String {
    let SetupError(message) =
        Packing::prepare(config, Seed { seed: 1, replicate: 0 }, false).err().unwrap();
    message.to_string()
}

fn on_lattice(config: PackingConfig) -> PackingConfig {
    PackingConfig { placement: PackingPlacement::Lattice, ..config }
}

fn in_box(discs: u32, width: f64, height: f64, radius: f64) -> PackingConfig {
    PackingConfig {
        discs: NonZeroU32::new(discs).unwrap(),
        width: BoxSide::new(width).unwrap(),
        height: BoxSide::new(height).unwrap(),
        radius: Positive::new(radius).unwrap(),
        ..PackingConfig::default()
    }
}

/// Smallest gap between two discs or between a disc and a wall, over the radius.
fn min_gap(config: &PackingConfig) -> f64 {
    let discs = disc_states(&prepare(config, 1, 0));
    assert_eq!(discs.len(), config.discs.get() as usize);
    let half = [0.5 * config.width.get(), 0.5 * config.height.get()];
    let mut min = f64::INFINITY;
    for (index, disc) in discs.iter().enumerate() {
        for (coordinate, half) in disc.position.iter().zip(half) {
            min = min.min(half - coordinate.abs() - disc.radius);
        }
        for other in &discs[..index] {
            min = min.min(distance(disc.position, other.position) - 2.0 * disc.radius);
        }
    }
    min / config.radius.get()
}

fn log_of_start(config: &PackingConfig) -> String {
    let frame = observe(&prepare(config, 1, 0));
    assert_eq!(frame.log_lines().len(), 1);
    frame.log_lines()[0].text.clone()
}

#[test]
fn placed_discs_are_inside_and_do_not_overlap() {
    let square = on_lattice(in_box(100, 20.0, 20.0, 1.0));
    assert!(log_of_start(&square).contains("square lattice, packing fraction 0.7854"));
    // 11 rows of 10 and 9 discs alternately: 20 x 20 contains rows at 0, sqrt 3, …, 10 sqrt 3 = 17.3 < 18.
    let hexagonal = on_lattice(in_box(105, 20.0, 20.0, 1.0));
    assert!(log_of_start(&hexagonal).contains("hexagonal rows"));
    // Two rows of 10, shifted by 1, need a width of 21; six rows need a height of 2 + 5 sqrt 3 = 10.66.
    let wide = on_lattice(in_box(60, 21.0, 10.7, 1.0));
    assert!(log_of_start(&wide).contains("hexagonal rows"));
    let rotated = on_lattice(in_box(60, 10.7, 21.0, 1.0));
    let dense = on_lattice(at_fraction(5000, 0.88));
    let single = on_lattice(in_box(1, 10.0, 10.0, 4.999));
    let random = [at_fraction(400, 0.45), in_box(2, 1e5, 10.0, 0.01)];
    assert!(log_of_start(&random[0]).contains("random sequential addition"));
    for config in [square, hexagonal, wide, rotated, dense, single].iter().chain(&random) {
        let gap = min_gap(config);
        println!("{} discs: smallest gap {gap:e} r", config.discs);
        assert!(gap > -1e-12);
    }
}

/// The packing exercise accepts every number of discs whose packing fraction is below 0.5: 254 of radius 1 in a box of 40 x 40.
#[test]
fn exercise_limit_of_the_packing_fraction_is_accepted() {
    let most = in_box(254, 40.0, 40.0, 1.0);
    for replicate in 0..40 {
        assert_eq!(disc_states(&prepare(&most, 1, replicate)).len(), 254);
    }
    assert!(log_of_start(&most).contains("packing fraction 0.4987"), "{}", log_of_start(&most));
    // Control.
    let text = rejection(&in_box(255, 40.0, 40.0, 1.0));
    assert!(text.contains("0.5007") && text.contains("below 0.5"), "{text}");
}

#[test]
fn initial_states_without_room_are_rejected_with_a_remedy() {
    let text = rejection(&at_fraction(200, 0.51));
    assert!(text.contains("below 0.5") && text.contains("lattice"), "{text}");
    // Below the limit, but the walls leave room for one disc only.
    let text = rejection(&in_box(2, 10.0, 10.0, 2.9));
    assert!(text.contains("0.5") && text.contains("lattice"), "{text}");
    // 11 rows of 10 and 9 discs alternately contain 6 x 10 + 5 x 9.
    let text = rejection(&on_lattice(in_box(106, 20.0, 20.0, 1.0)));
    assert!(text.contains("which hold 105"), "{text}");
    let text = rejection(&in_box(1, 10.0, 40.0, 5.0));
    assert!(text.contains("less than 5"), "{text}");
}

#[test]
fn valid_given_states_are_unchanged_and_invalid_ones_rejected() {
    let touching = given(&[[0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 1.0, 0.0], [19.0, -19.0, 0.0, 0.0]]);
    let discs = disc_states(&prepare(&touching, 0, 0));
    assert_eq!((discs[1].position, discs[1].velocity), ([2.0, 0.0], [1.0, 0.0]));
    assert!(log_of_start(&touching).contains("as given"));

    let overlapping = given(&[[9.0, 9.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [1.999, 0.0, 0.0, 0.0]]);
    assert!(rejection(&overlapping).contains("discs 1 and 2 overlap"));
    let outside = given(&[[0.0, 0.0, 0.0, 0.0], [0.0, 19.1, 0.0, 0.0]]);
    assert!(rejection(&outside).contains("disc 1 at [0, 19.1] is not inside"));
    let too_fast = given(&[[0.0, 0.0, 1e200, 0.0]]);
    assert!(rejection(&too_fast).contains("disc 0 has the speed"));
    let miscounted =
        PackingConfig { discs: NonZeroU32::new(3).unwrap(), ..given(&[[0.0, 0.0, 0.0, 0.0]]) };
    assert!(rejection(&miscounted).contains("discs = 3, but the placement gives 1 positions"));
}

#[test]
fn initial_states_are_reproducible_and_differ_between_replicates() {
    let config = at_fraction(50, 0.2);
    assert_eq!(prepare(&config, 3, 1), prepare(&config, 3, 1));
    assert_ne!(disc_states(&prepare(&config, 3, 1)), disc_states(&prepare(&config, 3, 2)));
    assert_ne!(disc_states(&prepare(&config, 3, 1)), disc_states(&prepare(&config, 4, 1)));
    let mut packing = prepare(&config, 3, 1);
    advance_to_count(&mut packing, 1);
    assert!(observe(&packing).log_lines().is_empty());
}

/// Discs with consecutive numbers are a few diameters apart on average, and no two overlap.
/// Setup: 20,000 discs placed at random.
/// Tolerance: 8 diameters; with random numbers, the mean would be 0.52 of the side of 143 diameters, 75 diameters.
#[test]
fn consecutive_discs_are_close_together() {
    let unequal =
        PackingConfig { radius_half_width: NonNegative::literal(0.3), ..at_fraction(20_000, 0.3) };
    for config in [at_fraction(20_000, 0.3), unequal] {
        let discs = disc_states(&prepare(&config, 1, 0));
        let distances = discs.windows(2).map(|two| distance(two[0].position, two[1].position));
        let mean = distances.sum::<f64>() / 19_999.0 / (2.0 * config.radius.get());
        println!("mean distance of consecutive discs: {mean:.2} diameters");
        assert!(mean < 8.0);
        let no_overlap = |one: &DiscState, other: &DiscState| {
            distance(one.position, other.position) >= (1.0 - 1e-12) * (one.radius + other.radius)
        };
        assert!(
            discs
                .windows(300)
                .all(|some| some[1..].iter().all(|other| no_overlap(&some[0], other)))
        );
    }
}

#[test]
fn scenery_is_the_box_centered_at_the_origin() {
    let scenery = prepare(&in_box(50, 40.0, 30.0, 1.0), 0, 0).scenery();
    assert_eq!(scenery.walls, [Wall::Rectangle { min: [-20.0, -15.0], max: [20.0, 15.0] }]);
    assert_eq!(scenery.view, [[-20.0, -15.0], [20.0, 15.0]]);
    assert_eq!(scenery.speed_range_top, 2.5 * 2.0_f64.sqrt());
    assert!(scenery.arrows);
    assert!(!prepare(&at_fraction(201, 0.1), 0, 0).scenery().arrows);
}
