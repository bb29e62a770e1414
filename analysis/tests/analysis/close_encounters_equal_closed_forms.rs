//! Law: the closest approach of two bodies is that of their motion and not that of the nearest frame.
//!
//! |r(t)| is least where r · v = 0: b on a straight line, a (1 - e) on an ellipse (Murray and Dermott, Solar System Dynamics,
//! section 2.3).
//!
//! Setup: frames of a uniform and of a Keplerian motion, made here, with the closest approach between two frames.
//! Tolerance: a cubic is exact for uniform motion, so rounding only, 1e-12; on the ellipse, the velocity turns by at most 0.7 of its size
//! between frames, for which the analysis states 1e-3.
//! Control: the least separation of the frames themselves is outside the tolerance.
#![allow(clippy::disallowed_methods, reason = "closed forms need std's maths")]

use crate::synthetic::{Folder, Frames};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;

/// States of all bodies at a time, in days.
type Motion<'a> = dyn Fn(f64) -> Vec<[f64; 6]> + 'a;

fn frames(motion: &Motion<'_>, interval: f64, count: u64) -> Frames {
    let at = |index: u64| {
        let time = index as f64 * interval;
        let mut frame = Frame::new();
        motion(time).iter().for_each(|row| frame.push_state(row));
        (Clock { count: index, time }, frame)
    };
    (0..=count).map(at).collect()
}

fn least_of_frames(motion: &Motion<'_>, interval: f64, count: u64) -> f64 {
    let separation = |index: u64| {
        let states = motion(index as f64 * interval);
        let [one, other] = [states[states.len() - 2], states[states.len() - 1]];
        (0..3).map(|axis| (other[axis] - one[axis]).powi(2)).sum::<f64>().sqrt()
    };
    (0..=count).map(separation).fold(f64::INFINITY, f64::min)
}

const REST: &str = "position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0]";
const MOVING: &str = "position_au = [1, 0, 0], velocity_au_per_day = [0, 1, 0]";

#[test]
fn closest_approach_of_a_straight_line_is_its_impact_parameter() {
    const IMPACT: f64 = 0.02;
    const SPEED: f64 = 0.01;
    const PASSES: f64 = 33.3;
    let motion = |time: f64| {
        let particle = [IMPACT, SPEED * (time - PASSES), 0.0, 0.0, SPEED, 0.0];
        vec![[0.0; 6], particle]
    };
    let manifest = format!(
        "name = \"line\"\n[model.orbit]\ntime_step_days = 0.5\nduration_days = 100\n\
         bodies = [{{ gm_au3_per_day2 = 1e-20, {REST} }}, {{ gm_au3_per_day2 = 0, {MOVING} }}]\n"
    );
    let metrics = Folder::write(&manifest, |_| frames(&motion, 10.0, 10)).metrics();
    metrics.assert_near("closest_approach", IMPACT, 1e-12);
    metrics.assert_near("closest_approach.time", PASSES, 1e-12);
    // |r| / (|v| h)
    metrics.assert_near("closest_approach.time_steps", IMPACT / (SPEED * 0.5), 1e-12);
    // Control.
    let of_frames = least_of_frames(&motion, 10.0, 10);
    assert!((of_frames / IMPACT - (IMPACT.hypot(0.033) / IMPACT)).abs() < 1e-12);
    assert!(of_frames > 1.5 * IMPACT, "{of_frames}");
}

/// State relative to the mass at rest, a = 1 AU, GM = 1 AU^3/day^2, by Kepler's equation.
fn ellipse(eccentricity: f64, mean: f64) -> [f64; 6] {
    let mut anomaly = mean;
    for _ in 0..200 {
        anomaly -=
            (anomaly - eccentricity * anomaly.sin() - mean) / (1.0 - eccentricity * anomaly.cos());
    }
    let (sine, cosine) = anomaly.sin_cos();
    let ratio = (1.0 - eccentricity * eccentricity).sqrt();
    let rate = 1.0 / (1.0 - eccentricity * cosine);
    [cosine - eccentricity, ratio * sine, 0.0, -rate * sine, rate * ratio * cosine, 0.0]
}

#[test]
fn closest_approach_of_an_ellipse_is_its_pericenter() {
    const ECCENTRICITY: f64 = 0.5;
    let manifest = format!(
        "name = \"ellipse\"\n[model.orbit]\nduration_days = 10\n\
         bodies = [{{ gm_au3_per_day2 = 1, {REST} }}, {{ gm_au3_per_day2 = 0, {MOVING} }}]\n"
    );
    // Forty frames per revolution; the pericenter is at half of an interval.
    const INTERVAL: f64 = std::f64::consts::TAU / 40.0;
    let motion = |time: f64| vec![[0.0; 6], ellipse(ECCENTRICITY, time - 2.5 * INTERVAL)];
    let pericenter = 1.0 - ECCENTRICITY;
    let metrics = Folder::write(&manifest, |_| frames(&motion, INTERVAL, 30)).metrics();
    metrics.assert_near("closest_approach", pericenter, 1e-3);
    let of_frames = least_of_frames(&motion, INTERVAL, 30);
    assert!(of_frames > 1.01 * pericenter, "control: {of_frames}");
    // With frames that do not follow the motion, the least separation is that of a frame.
    let coarse = 4.0 * INTERVAL;
    let metrics = Folder::write(&manifest, |_| frames(&motion, coarse, 8)).metrics();
    metrics.assert_near("closest_approach", least_of_frames(&motion, coarse, 8), 1e-12);
}

/// The Hill radius counts the distance from the central body; pairs with the central body are left out.
#[test]
fn closest_approach_is_compared_with_the_mutual_hill_radius() {
    const MASS: f64 = 3e-6;
    let motion = |_: f64| {
        let at = |x: f64| [x, 0.0, 0.0, 0.0, 1.0, 0.0];
        vec![[0.0; 6], at(1.0), at(1.02)]
    };
    let manifest = format!(
        "name = \"hill\"\n[model.orbit]\nduration_days = 10\nbodies = [{{ gm_au3_per_day2 = 1, {REST} }}, \
         {{ gm_au3_per_day2 = {MASS}, {MOVING} }}, {{ gm_au3_per_day2 = 0, position_au = [1.02, 0, 0], velocity_au_per_day = [0, 1, 0] }}]\n"
    );
    let metrics = Folder::write(&manifest, |_| frames(&motion, 1.0, 10)).metrics();
    metrics.assert_near("closest_approach", 0.02, 1e-12);
    // ((1 + 1.02)/2) (m/(3 M))^(1/3) = 1.01 * 0.01
    metrics.assert_near("closest_approach.hill_radii", 0.02 / 0.0101, 1e-12);
}
