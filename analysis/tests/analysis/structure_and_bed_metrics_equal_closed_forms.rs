//! Law: order, correlations, displacements and the load on a floor equal the values put into a recording.
//!
//! Setup: frames made by hand, so that each metric is known in closed form. Tolerance: rounding.
//! Control: two grains rotated by thirty degrees have no global order.
#![allow(clippy::disallowed_methods, missing_docs, reason = "closed forms need std's maths")]

use crate::synthetic::{Folder, Frames, Metrics};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::{DemEnergy, PackingTemperature};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;
use std::f64::consts::PI;

const PACKING: &str = r#"
name = "packing"
[model.packing]
discs = 36
radius = 1.0
width = 22.0
height = 22.0
events_per_disc = 10
[record]
frames = 2
channels = ["state", "temperature"]
"#;

/// Positions of the discs as a function of row and column, shifted by (0.3, 0.4) per frame; the
/// velocities are reversed in the last frame.
fn packing(position: fn(f64, f64) -> [f64; 2]) -> Metrics {
    let frames = |_: &RunManifest| -> Frames {
        (0..3_u32)
            .map(|index| {
                let mut frame = Frame::new();
                for disc in 0..36 {
                    let [x, y] = position(f64::from(disc / 6), f64::from(disc % 6));
                    let shift = f64::from(index);
                    let sign = if index == 2 { -0.5 } else { 1.0 };
                    let speed = f64::from(disc + 1) * sign;
                    frame.push_state(&[x + 0.3 * shift, y + 0.4 * shift, speed, 2.0 * speed]);
                }
                frame.push(&PackingTemperature::default());
                (Clock { count: u64::from(180 * index), time: f64::from(index) }, frame)
            })
            .collect()
    };
    Folder::write(PACKING, frames).metrics()
}

/// Every bond of a hexagonal lattice has the same angle modulo 60 degrees, also at its edge: |psi6| = 1, also globally. A rotation by
/// 10 degrees does not change this.
#[test]
fn hexagonal_lattice_has_perfect_order() {
    let metrics = packing(|row, column| {
        let (x, y) = (2.0 * column + row % 2.0, 3.0_f64.sqrt() * row);
        let (sine, cosine) = 10.0_f64.to_radians().sin_cos();
        [cosine * (x - 5.0) - sine * (y - 5.0), sine * (x - 5.0) + cosine * (y - 5.0)]
    });
    metrics.assert_near("psi6.global", 1.0, 1e-12);
    metrics.assert_near("psi6.local", 1.0, 1e-12);
    // Both frames from 180 events on are sampled, and they are equal.
    assert!(metrics.error("psi6.global").is_none());
}

/// Control: bonds that differ by 30 degrees cancel, exp(6 i 30 deg) = -1: half of the discs have one, half the other.
#[test]
fn control_grains_rotated_by_thirty_degrees_cancel() {
    let metrics = packing(|row, column| {
        // Pairs of discs with distances above 1.5 diameters; every second pair is rotated.
        let pair = (row * 6.0 + column) / 2.0;
        let (index, second) = (pair.floor(), pair.fract() > 0.0);
        let base = [3.4 * (index % 6.0) - 9.0, 6.0 * (index / 6.0).floor() - 8.0];
        let angle = if index % 2.0 == 0.0 { 0.0 } else { PI / 6.0 };
        let length = if second { 0.3 } else { 0.0 };
        [base[0] + length * angle.cos(), base[1] + length * angle.sin()]
    });
    metrics.assert_near("psi6.local", 1.0, 1e-12);
    metrics.assert_near("psi6.global", 0.0, 1e-12);
}

/// A square lattice of spacing 2.1 diameters has no pair within 1.1; spacing 1.05 has 60, divided by the number at random between 1 and
/// 1.1 in a box of 20 x 20, from the closed form of its pair distances.
#[test]
fn contact_value_is_relative_to_random_pairs() {
    let sparse = packing(|row, column| [3.2 * column - 8.0, 3.2 * row - 8.0]);
    sparse.assert_near("pair_correlation.near_contact", 0.0, 0.0);
    let dense = packing(|row, column| [2.1 * column - 6.0, 2.1 * row - 6.0]);
    let within = |r: f64| (PI * 400.0 - 160.0 / 3.0 * r + r * r / 2.0) * r * r / 160_000.0;
    let at_random = 36.0 * 35.0 / 2.0 * (within(2.2) - within(2.0));
    dense.assert_near("pair_correlation.near_contact", 60.0 / at_random, 1e-12);
}

#[test]
fn displacement_and_velocity_correlation_equal_those_of_the_frames() {
    let metrics = packing(|row, column| [2.1 * column - 6.0, 2.1 * row - 6.0]);
    metrics.assert_near("mean_square_displacement.final", 1.0, 1e-13);
    metrics.assert_near("velocity_autocorrelation.final", -0.5, 1e-14);
}

const BED: &str = r#"
name = "bed"
[model.dem]
discs = 2
mass_kg = 1e-3
radius_m = 5e-4
width_m = 2e-3
height_m = 4e-3
stiffness_n_per_m = 5e4
duration_s = 1.0
[record]
frames = 2
channels = ["state", "energy"]
"#;

/// Two adjacent discs at rest on the floor, each with an overlap of m g / k; one has half of this overlap with a wall.
fn bed_frames(_: &RunManifest) -> Frames {
    let sag = 1e-3 * 9.81 / 5e4;
    (0..3)
        .map(|index| {
            let mut frame = Frame::new();
            frame.push_state(&[5e-4 - sag / 2.0, 5e-4 - sag, 0.0, 0.0]);
            frame.push_state(&[1.5e-3, 5e-4 - sag, 0.0, 0.0]);
            let moving = if index == 0 { 1.0 } else { 0.0 };
            frame.push(&DemEnergy {
                kinetic_j: 1e-3 * moving,
                elastic_j: 1e-9,
                ..DemEnergy::default()
            });
            (Clock { count: index as u64, time: 0.5 * f64::from(index) }, frame)
        })
        .collect()
}

#[test]
fn floor_carries_the_weight_of_the_bed() {
    let metrics = Folder::write(BED, bed_frames).metrics();
    let weight = 2.0 * 1e-3 * 9.81;
    metrics.assert_near("floor.force", weight, 1e-9);
    assert!((metrics.theory("floor.force").unwrap() / weight - 1.0).abs() < 1e-12);
    metrics.assert_near("floor.stress", weight / 2e-3, 1e-9);
    let height = 2.0 * (5e-4 - 1e-3 * 9.81 / 5e4);
    metrics.assert_near("bed.height", height, 1e-12);
    metrics.assert_near("bed.packing_fraction", 2.0 * PI * 25e-8 / (2e-3 * height), 1e-12);
    metrics.assert_near("side_wall.stress", 1e-3 * 9.81 / 2.0 / (2.0 * height), 1e-8);
    metrics.assert_near("settling_time", 0.0, 0.0);
}
