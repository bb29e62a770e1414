//! Law: discs leave a flat-floored silo at a rate that goes as (D - k d)^(3/2), D the opening, d the diameter, and does not depend
//! on how high they stand.
//!
//! Source: Beverloo, Leniger and van de Velde, Chem. Eng. Sci. 15 (1961) 260, with k = 1.4; in the plane the power is 3/2 for 5/2.
//! Setup: `experiments/dem_hopper_discharge.toml`: openings of 5 and 11 diameters; one of 6.5 with half of the discs besides.
//! Tolerance: k is 1 to 2 for other grains; with 1.4 taken for it the power comes out between 1.40 and 1.68 (5 to 12 diameters): band
//! [1.35, 1.7]. A liquid's rate goes with the root of its height: 1.41 for twice the height; half of that way is allowed.
//! Control: rates in proportion to the opening (a liquid's) are rejected by the first judge.

use crate::scene::{frame, run_to_time, shipped_run};
use kinetoscope_manifest::model::DemConfig;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::DemWalls;
use std::num::NonZeroU32;

/// Discs a second between a tenth and half of all.
fn rate(words: &str, discs: u32) -> f64 {
    let (config, seed) = shipped_run("dem_hopper_discharge", words);
    let discs_config =
        DemConfig { discs: NonZeroU32::new(discs).expect("not zero"), ..config.clone() };
    let mut model =
        Dem::prepare(&discs_config, seed, false).unwrap_or_else(|refusal| panic!("{refusal}"));
    let left = |model: &Dem| {
        let walls: DemWalls = frame(model).get().expect("walls");
        walls.discs_removed as f64
    };
    let all = f64::from(discs);
    let (mut begin, mut time) = (None, 0.0);
    loop {
        time += 5e-3;
        assert!(time < 1.5, "the flow has stopped");
        run_to_time(&mut model, time);
        let gone = left(&model);
        if let Some((since, before)) = begin {
            if gone >= 0.5 * all {
                return (gone - before) / (time - since);
            }
        } else if gone >= 0.1 * all {
            begin = Some((time, gone));
        }
    }
}

fn exponent(rates: [f64; 2]) -> f64 {
    libm::log(rates[1] / rates[0]) / libm::log((11.0 - 1.4) / (5.0 - 1.4))
}

fn is_beverloos(exponent: f64) -> bool {
    (1.35..=1.7).contains(&exponent)
}

#[test]
fn the_rate_grows_as_the_free_opening_to_three_halves() {
    let rates = [rate("=5 diameters", 600), rate("=11 diameters", 600)];
    let exponent = exponent(rates);
    println!("{rates:.0?} discs a second: power {exponent:.3}");
    assert!(is_beverloos(exponent));
}

#[test]
fn the_rate_does_not_depend_on_the_height() {
    let (low, high) = (rate("=6.5 diameters", 400), rate("=6.5 diameters", 800));
    println!("{low:.0} discs a second from 400, {high:.0} from 800");
    assert!((high / low - 1.0).abs() < 0.2);
}

#[test]
fn a_liquid_is_rejected() {
    assert!(!is_beverloos(exponent([5.0, 11.0])));
    assert!(!is_beverloos(exponent([5.0 - 1.4, 11.0 - 1.4])));
}
