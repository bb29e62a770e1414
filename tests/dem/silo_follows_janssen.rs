//! Law: the floor of a silo carries Ws (1 - exp(-W/Ws)) of a weight W, with Ws = sigma g D^2/(2 mu K), where sigma is
//! the mass per area and D the width.
//!
//! Source: Janssen, Z. VDI 39 (1895) 1045; in two dimensions, the forces on a slice give D dp/dz = sigma g D - 2 mu K
//! p. K lies between the value of Rankine's active state, (1 - sin a)/(1 + sin a) = 0.3 at a large friction angle of 33
//! degrees, and 1.2, slightly above 1.
//! Setup: `experiments/dem_silo.toml`: the floor sinks by one diameter in a quarter of an oscillation and stops, so
//! that discs slip along the walls everywhere and friction is fully mobilized (as in Vanel and Clément, Eur. Phys. J. B
//! 11 (1999) 525).
//! Tolerance: Ws from the deepest bed, 480 discs, lies within the range of K; the load of 120 discs, a mean over four
//! beds, agrees within 20 % with the law, because force chains cause that scatter between single beds.
//! Control: with frictionless walls, the floor carries the weight within 1 %, as a mean over several oscillations of
//! the bed, which decay slowly; Janssen's law is rejected for them.

use crate::scene::{discs, frame, run_to_time, shipped_run};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::DemWalls;

const G: f64 = 9.81;

/// Mean load on the floor over `time`, s, after the floor has stopped, and the weight, N. The floor is the first wall
/// after the box's four.
fn load_and_weight(coordinates: &str, replicate: u32, time: f64) -> [f64; 2] {
    let (config, seed) = shipped_run("dem_silo", coordinates);
    let seed = Seed { replicate, ..seed };
    let mut model = Dem::prepare(&config, seed, false).unwrap_or_else(|error| panic!("{error}"));
    run_to_time(&mut model, 0.45);
    run_to_time(&mut model, 0.45 + time);
    let walls: DemWalls = frame(&model).get().expect("wall data");
    let weight: f64 = discs(&model).iter().map(|disc| disc.mass * G).sum();
    [walls.mean_force_y_n[4], weight]
}

/// Ws from one load, by bisection; `None` if the floor carries more than 95 %.
fn saturation_weight([load, weight]: [f64; 2]) -> Option<f64> {
    if load > 0.95 * weight {
        return None;
    }
    let carried = |scale: f64| scale * (1.0 - libm::exp(-weight / scale));
    let (mut low, mut high) = (1e-3 * weight, 1e3 * weight);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if carried(middle) < load { low = middle } else { high = middle }
    }
    Some(low)
}

/// Whether Ws, N, lies in the range of the law: sigma g D with a packing fraction of 0.8 to 0.85 and 1e-3 kg per pi
/// r^2, mu = 0.5, and K from 0.3 to 1.2.
fn is_saturation_weight(scale: f64) -> bool {
    let per_meter =
        |fraction: f64| fraction * 0.01 * 1e-3 * G / (std::f64::consts::PI * 5e-4 * 5e-4);
    let min = per_meter(0.8) * 0.01 / (2.0 * 0.5 * 1.2);
    let max = per_meter(0.85) * 0.01 / (2.0 * 0.5 * 0.3);
    (min..=max).contains(&scale)
}

#[test]
fn load_with_frictional_walls_follows_janssen() {
    let deep = load_and_weight("model.dem.discs=480 variant=rough", 0, 0.05);
    let beds = 4;
    let shallow = (0..beds)
        .map(|bed| load_and_weight("model.dem.discs=120 variant=rough", bed, 0.05))
        .fold([0.0; 2], |sum, bed| [0, 1].map(|at| sum[at] + bed[at] / f64::from(beds)));
    let scale = saturation_weight(deep).expect("the walls carry a part of the weight");
    let expected = scale * (1.0 - libm::exp(-shallow[1] / scale));
    println!(
        "load and weight {deep:.3?}: Ws = {scale:.3} N; {shallow:.3?}, expected {expected:.3}"
    );
    assert!(is_saturation_weight(scale), "{scale}");
    assert!((shallow[0] / expected - 1.0).abs() < 0.2);
}

#[test]
fn control_frictionless_walls_carry_no_weight() {
    let frictionless = load_and_weight("model.dem.discs=480 variant=frictionless", 0, 0.25);
    println!("load and weight {frictionless:.4?}");
    assert!((frictionless[0] / frictionless[1] - 1.0).abs() < 0.01);
    assert!(saturation_weight(frictionless).is_none_or(|scale| !is_saturation_weight(scale)));
}
