//! Law: the stress in a column of discs at rest equals the weight above per width: m g (n - i - 1/2)/width in the i-th layer from the floor,
//! counted from 0, if layers are as thick as the discs. For a column pressed by walls with a force h per disc, sigma_xx = h/(2 r).
//!
//! Source: balance of forces. The branches of a layer are half of the contact below, which carries n - i discs, and half of the contact
//! above, which carries one disc less, so that sigma_yy = (r (n - i) + r (n - i - 1)) m g/(2 r width).
//! Setup: frames made by hand.
//! Tolerance: rounding.
//! Control: a contact that carries half of its load, and moving discs.
#![allow(clippy::disallowed_methods, missing_docs, reason = "a test judges within tolerances")]

use crate::synthetic::{Folder, Frames, Metrics};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::{DemContactForces, DemEnergy};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;

const COLUMN: &str = r#"
name = "column"
[model.dem]
discs = 6
mass_kg = 1e-3
radius_m = 5e-4
width_m = 1.2e-3
height_m = 8e-3
duration_s = 1.0
[record]
frames = 20
channels = ["state", "energy", "contact_forces"]
"#;

const DISCS: u32 = 6;
const RADIUS: f64 = 5e-4;
const WIDTH: f64 = 1.2e-3;
/// Position of the column.
const X: f64 = 6e-4;
const WEIGHT: f64 = 1e-3 * 9.81;
/// Force of either wall on each disc, N.
const PRESSED: f64 = 2e-3;

fn push(forces: &mut DemContactForces, from: [f64; 2], to: [f64; 2], force: [f64; 2]) {
    forces.from_x_m.push(from[0]);
    forces.from_y_m.push(from[1]);
    forces.to_x_m.push(to[0]);
    forces.to_y_m.push(to[1]);
    forces.force_x_n.push(force[0]);
    forces.force_y_n.push(force[1]);
    // No metric needs the numbers of the discs.
    forces.first_id.push(0);
    forces.second_id.push(0);
}

/// A column on the floor. The lowest contact is recorded with a fraction of its load; the velocities of the discs cancel.
fn column(fraction: f64, speed: f64) -> Metrics {
    let frames = |_: &RunManifest| -> Frames {
        let frame = |index: u32| {
            let mut frame = Frame::new();
            let mut forces = DemContactForces::default();
            for disc in 0..DISCS {
                let y = RADIUS * f64::from(2 * disc + 1);
                let sign = if disc % 2 == 0 { 1.0 } else { -1.0 };
                frame.push_state(&[X, y, 0.0, sign * speed]);
                let carries = WEIGHT * f64::from(DISCS - disc);
                let force = if disc == 0 { fraction * carries } else { carries };
                let below = (y - 2.0 * RADIUS).max(0.0);
                // Recorded from either end: the sign depends on which disc is first.
                if disc % 2 == 0 {
                    push(&mut forces, [X, y], [X, below], [0.0, force]);
                } else {
                    push(&mut forces, [X, below], [X, y], [0.0, -force]);
                }
                push(&mut forces, [X, y], [0.0, y], [PRESSED, 0.0]);
                push(&mut forces, [X, y], [WIDTH, y], [-PRESSED, 0.0]);
            }
            frame.push(&forces);
            frame.push(&DemEnergy { elastic_j: 1e-9, ..DemEnergy::default() });
            (Clock { count: u64::from(index), time: 0.05 * f64::from(index) }, frame)
        };
        (0..=20).map(frame).collect()
    };
    Folder::write(COLUMN, frames).metrics()
}

#[test]
fn stress_equals_the_weight_above() {
    let metrics = column(1.0, 0.0);
    let at = |layer: f64| WEIGHT * (f64::from(DISCS) - layer - 0.5) / WIDTH;
    metrics.assert_near("stress.vertical_at_floor", at(0.0), 1e-12);
    assert!((metrics.theory("stress.vertical_at_floor").unwrap() / at(0.0) - 1.0).abs() < 1e-12);
    // 2.5 of six discs are above the middle of the fourth layer.
    metrics.assert_near("stress.vertical_at_mid_height", at(3.0), 1e-12);
    metrics.assert_near("stress.overburden_deviation", 0.0, 1e-12);
    // Six layers of h/(2 r) over the sum of (n - i - 1/2), 18 weights over the width.
    let ratio = 6.0 * PRESSED / (2.0 * RADIUS) / (18.0 * WEIGHT / WIDTH);
    metrics.assert_near("stress.lateral_ratio", ratio, 1e-12);
}

/// Control: if the contact with the floor is recorded with half of its load of 6 weights, the lowest layer loses 1.5 of 5.5.
#[test]
fn control_missing_force_is_found() {
    let metrics = column(0.5, 0.0);
    metrics.assert_near("stress.vertical_at_floor", 4.0 * WEIGHT / WIDTH, 1e-12);
    let theory = metrics.theory("stress.vertical_at_floor").unwrap();
    assert!((theory - 5.5 * WEIGHT / WIDTH).abs() < 1e-9, "{theory}");
    metrics.assert_near("stress.overburden_deviation", 1.5 / 6.0, 1e-12);
}

/// The mean velocity of a layer exerts no stress: a single disc has no velocity relative to its layer. For two discs of a layer with
/// velocities v and -v, the kinetic stress is the momentum flux 2 m v^2 over the area of the layer.
#[test]
fn kinetic_stress_depends_on_velocities_relative_to_the_layer() {
    let alone = column(1.0, 3.0);
    alone.assert_near("stress.vertical_at_floor", 5.5 * WEIGHT / WIDTH, 1e-12);
    let frames = |_: &RunManifest| -> Frames {
        let frame = |index: u32| {
            let mut frame = Frame::new();
            for (x, sign) in [(0.8e-3, 1.0), (2.4e-3, -1.0)] {
                frame.push_state(&[x, RADIUS, 0.0, sign * 0.3]);
            }
            frame.push(&DemContactForces::default());
            (Clock { count: u64::from(index), time: 0.05 * f64::from(index) }, frame)
        };
        (0..=20).map(frame).collect()
    };
    let manifest = COLUMN.replace("discs = 6", "discs = 2").replace("1.2e-3", "3.2e-3");
    let two = Folder::write(&manifest, frames).metrics();
    let carried = 2.0 * 1e-3 * 0.3 * 0.3 / (3.2e-3 * 2.0 * RADIUS);
    two.assert_near("stress.vertical_at_floor", carried, 1e-12);
}

/// Without recorded contact forces, or with walls that carry discs, no stress is reported.
#[test]
fn stress_requires_recorded_forces() {
    let frames = |_: &RunManifest| -> Frames {
        let mut frame = Frame::new();
        (0..DISCS).for_each(|disc| {
            frame.push_state(&[X, RADIUS * f64::from(2 * disc + 1), 0.0, 0.0]);
        });
        vec![(Clock { count: 0, time: 1.0 }, frame)]
    };
    assert!(Folder::write(COLUMN, frames).metrics().all("stress.vertical_at_floor").is_empty());
    let hopper = COLUMN.replace(
        "duration_s",
        "walls = [{ from_m = [0.0, 0.006], to_m = [5e-4, 0.004] }]\nduration_s",
    );
    let forces = |_: &RunManifest| -> Frames {
        let mut frame = Frame::new();
        frame.push_state(&[X, RADIUS, 0.0, 0.0]);
        let mut forces = DemContactForces::default();
        push(&mut forces, [X, RADIUS], [X, 0.0], [0.0, WEIGHT]);
        frame.push(&forces);
        vec![(Clock { count: 0, time: 1.0 }, frame)]
    };
    assert!(Folder::write(&hopper, forces).metrics().all("stress.vertical_at_floor").is_empty());
}
