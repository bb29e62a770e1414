//! Law: the mirror image of a start moves as the mirror image: left and right wall, and both signs of every normal, are alike.
//!
//! Source: the equations know no left or right.
//! Setup: 12 discs in a small box that collide with each other and both walls, and their images x -> width - x, 400 steps.
//! Tolerance: width - x is rounded, and collisions spread that: 1e-11 m. A contact's own error would be 1e-6 m.

use crate::scene::{discs, frame, given, positive, prepared, run_to};
use kinetoscope_manifest::model::DemConfig;
use kinetoscope_recording::channels::DemContacts;

const WIDTH: f64 = 0.008;

fn start(mirrored: bool, last_speed: f64) -> DemConfig {
    let places: Vec<_> = (0..12_u32)
        .map(|disc| {
            let (column, row) = (f64::from(disc % 4), f64::from(disc / 4));
            let speed = if disc == 11 { last_speed } else { 0.3 * f64::from(disc % 5) - 0.6 };
            let x = 0.0011 + 0.0019 * column;
            let (x, speed) = if mirrored { (WIDTH - x, -speed) } else { (x, speed) };
            ([x, 0.0007 + 0.0013 * row], [speed, -0.1])
        })
        .collect();
    let config =
        DemConfig { width_m: positive(WIDTH), height_m: positive(WIDTH), ..DemConfig::default() };
    given(config, &places)
}

/// Largest distance of a disc from its image's image, and whether both walls and a pair were touched.
fn largest_difference(last_speed: f64) -> (f64, [bool; 3]) {
    let mut model = prepared(&start(false, 0.3));
    let mut image = prepared(&start(true, last_speed));
    let mut touched = [false; 3];
    for step in 1..=400 {
        run_to(&mut model, step);
        run_to(&mut image, step);
        for line in frame(&model).contacts() {
            touched[0] |= line.to[0].abs() < 1e-15;
            touched[1] |= (line.to[0] - WIDTH).abs() < 1e-15;
        }
        let contacts: DemContacts = frame(&model).get().expect("contacts");
        touched[2] |= contacts.pair_contacts > 0;
    }
    let mut largest = 0.0;
    for (disc, image) in discs(&model).iter().zip(discs(&image)) {
        let apart = (disc.position[0] - (WIDTH - image.position[0])).abs()
            + (disc.position[1] - image.position[1]).abs();
        largest = if apart > largest { apart } else { largest };
    }
    (largest, touched)
}

#[test]
fn the_image_moves_as_the_image() {
    let (difference, touched) = largest_difference(0.3);
    println!("{difference:.1e} m");
    assert_eq!(touched, [true; 3], "left wall, right wall, pair");
    assert!(difference < 1e-11, "{difference:e}");
}

/// Control: another start of one disc is noticed.
#[test]
fn another_start_is_noticed() {
    assert!(largest_difference(0.31).0 > 1e-6);
}
