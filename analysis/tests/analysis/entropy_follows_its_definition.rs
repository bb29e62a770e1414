//! Law: the entropy by boxes is zero for particles that fill the container evenly and ln 2 for particles that fill one half of it, and the
//! change of the temperature is its largest change of any frame.
//!
//! Setup: frames made by hand. Source of the positions: the sunflower of Vogel 1979 (Math. Biosci. 44, 179), which fills a disc evenly.
//! Control: particles that have moved to the other half only, and a frame that is warmer by 1e-6.
#![allow(missing_docs, reason = "tests")]

use crate::synthetic::{Folder, Metrics};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::GasTemperature;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;
use std::f64::consts::LN_2;

const PARTICLES: u32 = 5000;
/// Vogel's angle between one seed and the next.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
const RADIUS_M: f64 = 1.0;

/// Where a particle of the last frame is, if it starts at `x` left of the partition.
type Motion = fn(u32, f64) -> f64;

fn expansion(last: Motion, warming: f64) -> Metrics {
    let manifest = format!(
        "name = \"gas\"\n[model.gas]\nparticles = {PARTICLES}\npartition_x_m = 0.0\npartition_opens_s = 0.01\nduration_s = 0.11\n[record]\nframes = 1\n"
    );
    let frames = move |_: &RunManifest| {
        let at = |(time, motion, mean_square_temperature_k): (f64, Motion, f64)| {
            let mut frame = Frame::new();
            for particle in 0..PARTICLES {
                let radius = RADIUS_M * ((f64::from(particle) + 0.5) / f64::from(PARTICLES)).sqrt();
                let (sine, cosine) = libm::sincos(f64::from(particle) * GOLDEN_ANGLE);
                let x = motion(particle, -(radius * cosine).abs());
                frame.push_state(&[x, radius * sine, 900.0, 0.0]);
            }
            frame.push(&GasTemperature { mean_square_temperature_k, ..Default::default() });
            (Clock { count: time as u64, time }, frame)
        };
        let stays: Motion = |_, x| x;
        [(0.0, stays, 300.0), (0.11, last, 300.0 * (1.0 + warming))].map(at).into()
    };
    Folder::write(&manifest, frames).metrics()
}

/// Every other particle moves to the mirrored place: both halves are filled.
fn into_both_halves(particle: u32, x: f64) -> f64 {
    if particle.is_multiple_of(2) { x } else { -x }
}

/// The theory's value is less by the scatter of 40 counts, which the even positions do not have: (3 B - 2)/(2 N) at most.
#[test]
fn entropy_rises_by_ln_2_when_both_halves_are_filled() {
    let scatter = 58.0 / (2.0 * f64::from(PARTICLES));
    let filled = expansion(into_both_halves, 0.0);
    assert!((filled.value("box_entropy.start") + LN_2).abs() < scatter);
    assert!((filled.value("box_entropy.change") - LN_2).abs() < scatter);
    let theory = filled.theory("box_entropy.change").unwrap();
    assert!((theory - LN_2).abs() < scatter);

    let moved = expansion(|_, x| -x, 0.0).value("box_entropy.change");
    assert!(moved.abs() < scatter && (moved - theory).abs() > 100.0 * scatter, "control: {moved}");
}

#[test]
fn change_of_the_temperature_is_the_largest_of_any_frame() {
    let name = "temperature.max_change_relative";
    assert_eq!(expansion(into_both_halves, 0.0).value(name), 0.0);
    let warmer = expansion(into_both_halves, 1e-6).value(name);
    assert!((warmer - 1e-6).abs() < 1e-12, "control: {warmer}");
}
