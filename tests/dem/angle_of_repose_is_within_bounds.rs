//! Law: the angle of repose of frictional discs lies between the angle of friction of a sheared bed and that of its discs.
//!
//! Source: a bed of discs shears at mu* = 0.26, almost independently of the discs' friction coefficient above 0.4 (da
//! Cruz et al., Phys. Rev. E 72 (2005) 021309): 14.6 degrees. Discs that slide without rolling have mu = 0.5: 26.6
//! degrees.
//! Setup: `experiments/dem_heap.toml`: insertion onto a platform of 50 diameters, bounded by edges one diameter high.
//! The angle is measured at the highest points of strips of two diameters, on both flanks; mean of four heaps.
//! Tolerance: [12, 27] degrees. A heap that has just slid is a few degrees flatter than one that is about to slide; the
//! angles of twelve heaps scatter by 2.7 degrees.
//! Control: the angle of frictionless discs is rejected.

use crate::scene::{discs, run_to_time, shipped_run};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use std::f64::consts::PI;

/// Center of the platform and its height, m.
const MIDDLE: f64 = 0.035;
const PLATFORM: f64 = 0.004;
/// Width of a strip, m.
const STRIP: f64 = 2e-3;
const REPLICATES: u32 = 4;

/// Mean surface angle of the replicates, degrees.
fn mean_angle(friction: &str) -> f64 {
    (0..REPLICATES).map(|replicate| surface_angle(friction, replicate)).sum::<f64>()
        / f64::from(REPLICATES)
}

/// Angle of the line fitted to the surface height over the distance from the center, degrees, without foot and tip.
fn surface_angle(friction: &str, replicate: u32) -> f64 {
    let (config, seed) = shipped_run("dem_heap", &format!("friction={friction} "));
    let seed = Seed { replicate, ..seed };
    let mut model = Dem::prepare(&config, seed, false).unwrap_or_else(|error| panic!("{error}"));
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
    let angle = libm::atan(-products / squares) * 180.0 / PI;
    println!("friction {friction}, heap {replicate}: {angle:.1} degrees");
    angle
}

fn is_angle_of_repose(angle: f64) -> bool {
    (12.0..=27.0).contains(&angle)
}

#[test]
fn angle_of_frictional_heap_is_within_bounds() {
    let angle = mean_angle("0.5");
    println!("mean angle {angle:.1} degrees");
    assert!(is_angle_of_repose(angle));
}

#[test]
fn control_frictionless_heap_is_rejected() {
    let angle = mean_angle("0");
    println!("mean angle {angle:.1} degrees");
    assert!(!is_angle_of_repose(angle));
}
