//! Law: a gas of dissipative discs cools as T = T0/(1 + t/tau)^2, 1/tau = (1 - e^2) w0/4, with Enskog's collision rate
//! w0 = 2 sqrt(pi) n s g sqrt(T0), g = (1 - 7 f/16)/(1 - f)^2.
//!
//! Source: Haff, J. Fluid Mech. 134 (1983) 401; each collision takes (1 - e^2) m v_n^2/4, whose mean over the flux of
//! Maxwell's velocities is (1 - e^2) m T; g by Henderson, Mol. Phys. 30 (1975) 971.
//! Setup: `experiments/dem_granular_gas.toml`, three of its replicates, for one tau: later, vortices hold a growing part of the
//! energy (Brito and Ernst, Europhys. Lett. 43 (1998) 497).
//! Tolerance: 5 % of 1/tau. N w0 tau/4 = 1e4 collisions a run leave 1 % of chance; a contact lasts 1 % of the time between two.
//! Control: discs of e = 0.97 and elastic ones are rejected.

use crate::scene::{frame, restitution, run_to_time, shipped};
use kinetoscope_manifest::model::DemConfig;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::DemTemperature;
use std::f64::consts::PI;

const FRAMES: u32 = 12;

fn temperature(model: &Dem) -> f64 {
    let seen: DemTemperature = frame(model).get().expect("a temperature");
    seen.granular_temperature_m2_per_s2
}

/// 1/tau by least squares of sqrt(T0/T) - 1 = t/tau, over what Haff's law says.
fn rate_over_law(config: &DemConfig, seed: Seed, e: f64) -> f64 {
    let mut model = Dem::prepare(config, seed, false).unwrap_or_else(|refusal| panic!("{refusal}"));
    let first = temperature(&model);
    let (mut products, mut squares) = (0.0, 0.0);
    for number in 1..=FRAMES {
        let time = config.duration_s.get() * f64::from(number) / f64::from(FRAMES);
        run_to_time(&mut model, time);
        products += time * ((first / temperature(&model)).sqrt() - 1.0);
        squares += time * time;
    }
    let (radius, side) = (5e-4, 0.0627);
    let density = 1000.0 / (side * side);
    let fraction = PI * radius * radius * density;
    let crowding = (1.0 - 7.0 / 16.0 * fraction) / ((1.0 - fraction) * (1.0 - fraction));
    let collisions = 2.0 * PI.sqrt() * density * 2.0 * radius * crowding * first.sqrt();
    products / squares / ((1.0 - e * e) * collisions / 4.0)
}

#[test]
fn the_rate_of_cooling_is_haffs() {
    let runs = shipped("dem_granular_gas");
    let rates: Vec<f64> =
        runs.iter().take(3).map(|(_, config, seed)| rate_over_law(config, *seed, 0.95)).collect();
    let mean = rates.iter().sum::<f64>() / 3.0;
    println!("1/tau over Haff's: {rates:.4?}, mean {mean:.4}");
    assert!((mean - 1.0).abs() < 0.05, "{mean}");
}

#[test]
fn another_restitution_is_noticed() {
    let (_, config, seed) = shipped("dem_granular_gas").swap_remove(0);
    for e in [0.97, 1.0] {
        let config = DemConfig { dissipation: restitution(e), ..config.clone() };
        let rate = rate_over_law(&config, seed, 0.95);
        println!("e = {e}: {rate:.4} of Haff's rate for 0.95");
        assert!((rate - 1.0).abs() > 0.05);
    }
}
