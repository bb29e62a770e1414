//! Law: the floor of a silo carries Ws (1 - exp(-W/Ws)) of a weight W, Ws = sigma g D^2/(2 mu K) (sigma the mass of unit area, D
//! the width): from some height on, no more.
//!
//! Source: Janssen, Z. VDI 39 (1895) 1045; in the plane, forces on a slice: D d(p)/dz = sigma g D - 2 mu K p. K lies between that
//! of Rankine's active state, (1 - sin a)/(1 + sin a) = 0.3 at a steep angle of friction of 33 degrees, and somewhat above 1.
//! Setup: `experiments/dem_silo.toml`: the floor sinks by a diameter, in a quarter of an oscillation, so that discs slip
//! along the walls everywhere and friction is used up (as Vanel and Clément did, Eur. Phys. J. B 11 (1999) 525), and comes to rest.
//! Tolerance: Ws from the deepest bed, W(480 discs), within the range of K; the 120 discs' load, a mean over four beds, within
//! 20 % of that law: chains of forces make single beds scatter by that much.
//! Control: with smooth walls the floor carries all, to 1 %, as a mean over several of the bed's bounces, which lessen slowly; and
//! the judge of Janssen's law rejects that.

use crate::scene::{discs, frame, run_to_time, shipped_run};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::DemWalls;

const G: f64 = 9.81;

/// Load of the floor, the first wall behind the box's four, as a mean over some time, s, after it has come to rest, and the
/// weight, N.
fn load_and_weight(words: &str, replicate: u32, time: f64) -> [f64; 2] {
    let (config, seed) = shipped_run("dem_silo", words);
    let seed = Seed { replicate, ..seed };
    let mut model =
        Dem::prepare(&config, seed, false).unwrap_or_else(|refusal| panic!("{refusal}"));
    run_to_time(&mut model, 0.45);
    run_to_time(&mut model, 0.45 + time);
    let walls: DemWalls = frame(&model).get().expect("walls");
    let weight: f64 = discs(&model).iter().map(|disc| disc.mass * G).sum();
    [walls.mean_force_y_n[4], weight]
}

/// Ws of one load, by bisection; `None` where the floor carries more than 95 %.
fn screening_weight([load, weight]: [f64; 2]) -> Option<f64> {
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

/// The range of Ws, N: sigma g D = 0.8 to 0.85 of the area times 1e-3 kg over pi r^2, mu = 0.5, K from 0.3 to
/// 1.2.
fn is_janssens(scale: f64) -> bool {
    let per_meter =
        |fraction: f64| fraction * 0.01 * 1e-3 * G / (std::f64::consts::PI * 5e-4 * 5e-4);
    let least = per_meter(0.8) * 0.01 / (2.0 * 0.5 * 1.2);
    let most = per_meter(0.85) * 0.01 / (2.0 * 0.5 * 0.3);
    (least..=most).contains(&scale)
}

#[test]
fn rough_walls_carry_what_janssen_says() {
    let deep = load_and_weight("model.dem.discs=480 variant=rough", 0, 0.05);
    let beds = 4;
    let shallow = (0..beds)
        .map(|bed| load_and_weight("model.dem.discs=120 variant=rough", bed, 0.05))
        .fold([0.0; 2], |sum, bed| [0, 1].map(|at| sum[at] + bed[at] / f64::from(beds)));
    let scale = screening_weight(deep).expect("the walls carry some");
    let expected = scale * (1.0 - libm::exp(-shallow[1] / scale));
    println!(
        "load and weight {deep:.3?}: Ws = {scale:.3} N; {shallow:.3?}, expected {expected:.3}"
    );
    assert!(is_janssens(scale), "{scale}");
    assert!((shallow[0] / expected - 1.0).abs() < 0.2);
}

#[test]
fn smooth_walls_carry_nothing() {
    let smooth = load_and_weight("model.dem.discs=480 variant=smooth", 0, 0.25);
    println!("load and weight {smooth:.4?}");
    assert!((smooth[0] / smooth[1] - 1.0).abs() < 0.01);
    assert!(screening_weight(smooth).is_none_or(|scale| !is_janssens(scale)));
}
