//! Laws of the start: discs stand inside and apart, however dense; what can't be built is refused with what would do; the
//! start's log says how it came about; seeds and replicates differ and repeat.
//! Source: packing document, input limits; capacity of hexagonal rows by hand where stated.

// A test judges within tolerances: no bit of a run depends on it.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::runs::{Seen, advance_to_count, at_fraction, distance, given, look, observe, prepare};
use kinetoscope_manifest::model::{PackingConfig, PackingPlacement};
use kinetoscope_manifest::quantity::{BoxSide, NonNegative, Positive};
use kinetoscope_physics::model::{Model, Refusal};
use kinetoscope_physics::packing::Packing;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::scenery::Wall;
use std::num::NonZeroU32;

fn refusal(config: &PackingConfig) -> String {
    let Refusal(words) =
        Packing::prepare(config, Seed { seed: 1, replicate: 0 }, false).err().unwrap();
    words
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

/// Smallest gap of two discs or of a disc and a wall, over the radius.
fn smallest_gap(config: &PackingConfig) -> f64 {
    let seen = look(&prepare(config, 1, 0));
    assert_eq!(seen.len(), config.discs.get() as usize);
    let half = [0.5 * config.width.get(), 0.5 * config.height.get()];
    let mut smallest = f64::INFINITY;
    for (index, disc) in seen.iter().enumerate() {
        for (place, half) in disc.position.iter().zip(half) {
            smallest = smallest.min(half - place.abs() - disc.radius);
        }
        for other in &seen[..index] {
            smallest = smallest.min(distance(disc.position, other.position) - 2.0 * disc.radius);
        }
    }
    smallest / config.radius.get()
}

fn log_of_start(config: &PackingConfig) -> String {
    let frame = observe(&prepare(config, 1, 0));
    assert_eq!(frame.log_lines().len(), 1);
    frame.log_lines()[0].text.clone()
}

#[test]
fn discs_stand_inside_and_apart() {
    let square = on_lattice(in_box(100, 20.0, 20.0, 1.0));
    assert!(log_of_start(&square).contains("square lattice, packing fraction 0.7854"));
    // 11 rows of 10 and 9 in turn: 20 x 20 holds rows at 0, sqrt 3, …, 10 sqrt 3 = 17.3 < 18.
    let hexagonal = on_lattice(in_box(105, 20.0, 20.0, 1.0));
    assert!(log_of_start(&hexagonal).contains("hexagonal rows"));
    // Rows of 10 and 10 shifted by 1 need a width of 21; six of them a height of 2 + 5 sqrt 3 = 10.66.
    let wide = on_lattice(in_box(60, 21.0, 10.7, 1.0));
    assert!(log_of_start(&wide).contains("hexagonal rows"));
    let turned = on_lattice(in_box(60, 10.7, 21.0, 1.0));
    let dense = on_lattice(at_fraction(5000, 0.88));
    let lonely = on_lattice(in_box(1, 10.0, 10.0, 4.999));
    let random = [at_fraction(400, 0.45), in_box(2, 1e5, 10.0, 0.01)];
    assert!(log_of_start(&random[0]).contains("random sequential addition"));
    for config in [square, hexagonal, wide, turned, dense, lonely].iter().chain(&random) {
        let gap = smallest_gap(config);
        println!("{} discs: smallest gap {gap:e} r", config.discs);
        assert!(gap > -1e-12);
    }
}

#[test]
fn what_does_not_fit_is_refused_with_what_would_do() {
    let words = refusal(&at_fraction(200, 0.51));
    assert!(words.contains("below 0.5") && words.contains("lattice"), "{words}");
    // Below the limit, but walls leave room for one disc only.
    let words = refusal(&in_box(2, 10.0, 10.0, 2.9));
    assert!(words.contains("0.5") && words.contains("lattice"), "{words}");
    // 11 rows of 10 and 9 in turn hold 6 x 10 + 5 x 9.
    let words = refusal(&on_lattice(in_box(106, 20.0, 20.0, 1.0)));
    assert!(words.contains("which hold 105"), "{words}");
    let words = refusal(&in_box(1, 10.0, 40.0, 5.0));
    assert!(words.contains("below 5"), "{words}");
}

#[test]
fn given_starts_are_taken_as_they_are_or_refused() {
    let touching = given(&[[0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 1.0, 0.0], [19.0, -19.0, 0.0, 0.0]]);
    let seen = look(&prepare(&touching, 0, 0));
    assert_eq!((seen[1].position, seen[1].velocity), ([2.0, 0.0], [1.0, 0.0]));
    assert!(log_of_start(&touching).contains("as given"));

    let overlapping = given(&[[9.0, 9.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [1.999, 0.0, 0.0, 0.0]]);
    assert!(refusal(&overlapping).contains("discs 1 and 2 overlap"));
    let outside = given(&[[0.0, 0.0, 0.0, 0.0], [0.0, 19.1, 0.0, 0.0]]);
    assert!(refusal(&outside).contains("disc 1 at [0, 19.1] is not inside"));
    let too_fast = given(&[[0.0, 0.0, 1e200, 0.0]]);
    assert!(refusal(&too_fast).contains("disc 0 has the speed"));
    let miscounted =
        PackingConfig { discs: NonZeroU32::new(3).unwrap(), ..given(&[[0.0, 0.0, 0.0, 0.0]]) };
    assert!(refusal(&miscounted).contains("discs = 3, but the placement gives 1 positions"));
}

#[test]
fn starts_repeat_with_their_seed_and_differ_between_replicates() {
    let config = at_fraction(50, 0.2);
    assert_eq!(prepare(&config, 3, 1), prepare(&config, 3, 1));
    assert_ne!(look(&prepare(&config, 3, 1)), look(&prepare(&config, 3, 2)));
    assert_ne!(look(&prepare(&config, 3, 1)), look(&prepare(&config, 4, 1)));
    let mut packing = prepare(&config, 3, 1);
    advance_to_count(&mut packing, 1);
    assert!(observe(&packing).log_lines().is_empty());
}

/// Of 20,000 discs at random places those that follow each other in number stand a few diameters apart, on average, and
/// no two overlap. At random numbers they would be half a box apart, some 75 diameters: 0.52 of the side of 143.
#[test]
fn many_discs_are_numbered_by_their_places() {
    let unequal =
        PackingConfig { polydispersity: NonNegative::literal(0.3), ..at_fraction(20_000, 0.3) };
    for config in [at_fraction(20_000, 0.3), unequal] {
        let seen = look(&prepare(&config, 1, 0));
        let apart = seen.windows(2).map(|two| distance(two[0].position, two[1].position));
        let mean = apart.sum::<f64>() / 19_999.0 / (2.0 * config.radius.get());
        println!("mean distance of discs that follow each other: {mean:.2} diameters");
        assert!(mean < 8.0);
        let next = |one: &Seen, other: &Seen| {
            distance(one.position, other.position) >= (1.0 - 1e-12) * (one.radius + other.radius)
        };
        assert!(seen.windows(300).all(|some| some[1..].iter().all(|other| next(&some[0], other))));
    }
}

#[test]
fn the_drawing_is_the_box_about_the_origin() {
    let scenery = prepare(&in_box(50, 40.0, 30.0, 1.0), 0, 0).scenery();
    assert_eq!(scenery.walls, [Wall::Rectangle { min: [-20.0, -15.0], max: [20.0, 15.0] }]);
    assert_eq!(scenery.view, [[-20.0, -15.0], [20.0, 15.0]]);
    assert_eq!(scenery.speed_range_top, 2.5 * 2.0_f64.sqrt());
    assert!(scenery.arrows);
    assert!(!prepare(&at_fraction(201, 0.1), 0, 0).scenery().arrows);
}
