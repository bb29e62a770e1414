//! Law: discs with friction pile up, at an angle whose tangent lies between the friction of a sheared bed and that of its discs.
//!
//! Source: a bed of discs shears from mu* = 0.26 on, which hardly depends on the discs' own mu above 0.4 (da Cruz et al., Phys. Rev.
//! E 72 (2005) 021309): 14.6 degrees; discs that all slide and do not roll have mu = 0.5: 26.6 degrees.
//! Setup: `experiments/dem_heap.toml`: rain on a platform of 50 diameters with edges of one.
//! Tolerance: [12, 27] degrees for the mean of four heaps: one that has just slid is up to some degrees flatter than one that is
//! about to (of twelve, the slopes scatter by 2.7 degrees).
//! Measured by the highest points over strips of two diameters, on both flanks.
//! Control: discs without friction lie flat: their heap is rejected.

use crate::scene::{discs, run_to_time, shipped_run};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use std::f64::consts::PI;

/// Middle of the platform and its height, m.
const MIDDLE: f64 = 0.035;
const PLATFORM: f64 = 0.004;
/// Width of a strip, m.
const STRIP: f64 = 2e-3;
const REPLICATES: u32 = 4;

/// Mean slope of some heaps, degrees.
fn slope(friction: &str) -> f64 {
    (0..REPLICATES).map(|replicate| slope_of(friction, replicate)).sum::<f64>()
        / f64::from(REPLICATES)
}

/// Slope of the line through the surface's height over the distance from the middle, degrees: foot and tip left out.
fn slope_of(friction: &str, replicate: u32) -> f64 {
    let (config, seed) = shipped_run("dem_heap", &format!("friction={friction} "));
    let seed = Seed { replicate, ..seed };
    let mut model =
        Dem::prepare(&config, seed, false).unwrap_or_else(|refusal| panic!("{refusal}"));
    run_to_time(&mut model, config.duration_s.get());
    let mut tops = [0.0_f64; 35];
    for disc in discs(&model) {
        let top = &mut tops[(disc.position[0] / STRIP) as usize];
        let height = disc.position[1] + disc.radius - PLATFORM;
        *top = if height > *top { height } else { *top };
    }
    let peak = tops.iter().fold(0.0, |peak, &top| if top > peak { top } else { peak });
    let strips = tops.iter().enumerate().map(|(strip, &top)| {
        let x = (strip as f64 + 0.5) * STRIP - MIDDLE;
        [x.abs(), top]
    });
    let flank: Vec<[f64; 2]> =
        strips.filter(|[_, top]| *top > 0.15 * peak && *top < 0.85 * peak).collect();
    let count = flank.len() as f64;
    let mean = |of: usize| flank.iter().map(|point| point[of]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let products: f64 = flank.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    let squares: f64 = flank.iter().map(|point| (point[0] - x) * (point[0] - x)).sum();
    let slope = libm::atan(-products / squares) * 180.0 / PI;
    println!("friction {friction}, heap {replicate}: {slope:.1} degrees");
    slope
}

fn is_a_heaps(slope: f64) -> bool {
    (12.0..=27.0).contains(&slope)
}

#[test]
fn rubbing_discs_pile_up() {
    let slope = slope("0.5");
    println!("slope {slope:.1} degrees");
    assert!(is_a_heaps(slope));
}

#[test]
fn smooth_discs_do_not() {
    let slope = slope("0");
    println!("slope {slope:.1} degrees");
    assert!(!is_a_heaps(slope));
}
