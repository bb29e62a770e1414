//! Law: the discharge rate of a flat-floored silo in two dimensions is proportional to (D - k d)^(3/2), where D is the
//! width of the orifice and d the diameter, and is independent of the fill height.
//!
//! Source: Beverloo, Leniger and van de Velde, Chem. Eng. Sci. 15 (1961) 260, with k = 1.4; the power is 5/2 in three
//! dimensions and 3/2 in two. One k describes only a limited range of widths (Mankoc et al., Granular Matter 9 (2007)
//! 407).
//! Setup: `experiments/dem_hopper_discharge.toml`: orifices of 5 and 11 diameters; one of 6.5 diameters with 400 and
//! with 800 discs.
//! Tolerance: the power lies in [1.35, 1.7]. Grains have k between 1 and 2; if k = 1.4 is assumed, the power is between
//! 1.40 and 1.68 for 5 to 12 diameters. The rates of the two heights agree within 20 %, half of the difference for a
//! liquid, whose rate grows as the root of the height (a factor of 1.41).
//! Control: rates proportional to the width of the orifice or to the effective width are rejected.

use crate::scene::{frame, run_to_time, shipped_run};
use kinetoscope_manifest::model::DemConfig;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::DemWalls;
use std::num::NonZeroU32;

/// Discharge rate, discs per second, between a tenth and half of all discs.
fn rate(coordinates: &str, discs: u32) -> f64 {
    let (config, seed) = shipped_run("dem_hopper_discharge", coordinates);
    let discs_config =
        DemConfig { discs: NonZeroU32::new(discs).expect("not zero"), ..config.clone() };
    let mut model =
        Dem::prepare(&discs_config, seed, false).unwrap_or_else(|error| panic!("{error}"));
    let removed = |model: &Dem| {
        let walls: DemWalls = frame(model).get().expect("wall data");
        walls.discs_removed as f64
    };
    let all = f64::from(discs);
    let (mut begin, mut time) = (None, 0.0);
    loop {
        time += 5e-3;
        assert!(time < 1.5, "the flow has stopped");
        run_to_time(&mut model, time);
        let now = removed(&model);
        if let Some((since, before)) = begin {
            if now >= 0.5 * all {
                return (now - before) / (time - since);
            }
        } else if now >= 0.1 * all {
            begin = Some((time, now));
        }
    }
}

fn exponent(rates: [f64; 2]) -> f64 {
    libm::log(rates[1] / rates[0]) / libm::log((11.0 - 1.4) / (5.0 - 1.4))
}

fn is_accepted(exponent: f64) -> bool {
    (1.35..=1.7).contains(&exponent)
}

#[test]
fn rate_grows_as_effective_width_to_three_halves() {
    let rates = [rate("=5 diameters", 600), rate("=11 diameters", 600)];
    let exponent = exponent(rates);
    println!("{rates:.0?} discs per second: power {exponent:.3}");
    assert!(is_accepted(exponent));
}

#[test]
fn rate_is_independent_of_fill_height() {
    let (low, high) = (rate("=6.5 diameters", 400), rate("=6.5 diameters", 800));
    println!("{low:.0} discs per second from 400, {high:.0} from 800");
    assert!((high / low - 1.0).abs() < 0.2);
}

#[test]
fn control_rate_proportional_to_width_is_rejected() {
    assert!(!is_accepted(exponent([5.0, 11.0])));
    assert!(!is_accepted(exponent([5.0 - 1.4, 11.0 - 1.4])));
}
