//! Law: the mirror image of an initial state moves as the mirror image: the left and the right wall, and both signs of
//! every normal, are equivalent.
//!
//! Source: the equations of motion are invariant under x -> width - x.
//! Setup: 12 discs in a small box that collide with each other and with both walls, and their images x -> width - x,
//! 400 steps.
//! Tolerance: 1e-11 m, because width - x is rounded and collisions amplify the rounding. An error in a contact would
//! cause 1e-6 m.
//! Control: a different initial velocity of one disc causes more than 1e-6 m.

use crate::scene::{discs, frame, given, positive, prepared, run_to};
use kinetoscope_manifest::model::DemConfig;
use kinetoscope_recording::channels::DemContactStatistics;

const WIDTH: f64 = 0.008;

fn start(is_mirrored: bool, last_speed: f64) -> DemConfig {
    let discs: Vec<_> = (0..12_u32)
        .map(|disc| {
            let (column, row) = (f64::from(disc % 4), f64::from(disc / 4));
            let speed = if disc == 11 { last_speed } else { 0.3 * f64::from(disc % 5) - 0.6 };
            let x = 0.0011 + 0.0019 * column;
            let (x, speed) = if is_mirrored { (WIDTH - x, -speed) } else { (x, speed) };
            ([x, 0.0007 + 0.0013 * row], [speed, -0.1])
        })
        .collect();
    let config =
        DemConfig { width_m: positive(WIDTH), height_m: positive(WIDTH), ..DemConfig::default() };
    given(config, &discs)
}

/// Largest distance between a disc and the mirror image of its image, and whether the left wall, the right wall and a
/// pair were in contact.
fn max_difference(last_speed: f64) -> (f64, [bool; 3]) {
    let mut model = prepared(&start(false, 0.3));
    let mut image = prepared(&start(true, last_speed));
    let mut had_contact = [false; 3];
    for step in 1..=400 {
        run_to(&mut model, step);
        run_to(&mut image, step);
        for line in frame(&model).contacts() {
            had_contact[0] |= line.to[0].abs() < 1e-15;
            had_contact[1] |= (line.to[0] - WIDTH).abs() < 1e-15;
        }
        let contacts: DemContactStatistics = frame(&model).get().expect("contact statistics");
        had_contact[2] |= contacts.pair_contacts > 0;
    }
    let mut max = 0.0;
    for (disc, image) in discs(&model).iter().zip(discs(&image)) {
        let distance = (disc.position[0] - (WIDTH - image.position[0])).abs()
            + (disc.position[1] - image.position[1]).abs();
        max = if distance > max { distance } else { max };
    }
    (max, had_contact)
}

#[test]
fn mirror_image_moves_as_the_mirror_image() {
    let (difference, had_contact) = max_difference(0.3);
    println!("{difference:.1e} m");
    assert_eq!(had_contact, [true; 3], "contacts of left wall, right wall and a pair");
    assert!(difference < 1e-11, "{difference:e}");
}

#[test]
fn control_different_initial_velocity_is_rejected() {
    assert!(max_difference(0.31).0 > 1e-6);
}
