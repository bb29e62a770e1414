//! Law: discs with friction pile up, at an angle whose tangent lies between the friction of a sheared bed and that of its discs.
//!
//! Source: a bed of discs shears from mu* = 0.26 on, which hardly depends on the discs' own mu above 0.4 (da Cruz et al., Phys. Rev.
//! E 72 (2005) 021309): 14.6 degrees; discs that all slide and do not roll have mu = 0.5: 26.6 degrees.
//! Setup: `experiments/dem_heap.toml`: rain on a platform of 50 diameters with edges of one.
//! Tolerance: [12, 27] degrees: a heap that has just slid is up to some degrees flatter than one that is about to.
//! Measured by the triangle of the area and the base of the discs above the edges, which cover 0.82 of it (random close packing).
//! Control: discs without friction lie flat: their heap is rejected.

mod dem_scene;

use dem_scene::{discs, run_to_time, shipped_run};
use kinetoscope::model::Model;
use kinetoscope::models::dem::Dem;
use std::f64::consts::PI;

/// Top of the platform's edges, m.
const EDGE: f64 = 0.005;
const PACKING: f64 = 0.82;

/// atan(4 A/B^2) in degrees.
fn slope(friction: &str) -> f64 {
    let (config, seed) = shipped_run("dem_heap", &format!("friction={friction} "));
    let mut model =
        Dem::prepare(&config, seed, false).unwrap_or_else(|refusal| panic!("{refusal}"));
    run_to_time(&mut model, config.duration_s.get());
    let (mut area, mut low, mut high) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for disc in discs(&model).iter().filter(|disc| disc.position[1] > EDGE) {
        area += PI * disc.radius * disc.radius / PACKING;
        let [x, _] = disc.position;
        low = if x - disc.radius < low { x - disc.radius } else { low };
        high = if x + disc.radius > high { x + disc.radius } else { high };
    }
    let base = high - low;
    libm::atan(4.0 * area / (base * base)) * 180.0 / PI
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
