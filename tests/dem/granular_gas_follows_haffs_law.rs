//! Law: T = T0/(1 + t/tau)^2 in a gas of dissipative discs, with 1/tau = (1 - e^2) w0/4, Enskog's collision rate per disc
//! w0 = 2 sqrt(pi) n s g sqrt(T0), and g = (1 - 7 f/16)/(1 - f)^2 at the packing fraction f.
//!
//! Source: Haff, J. Fluid Mech. 134 (1983) 401. Each collision dissipates (1 - e^2) m v_n^2/4, whose mean over the flux
//! of Maxwell's velocities is (1 - e^2) m T. g: Henderson, Mol. Phys. 30 (1975) 971.
//! Setup: `experiments/dem_granular_gas.toml`, three replicates for one tau. Later, vortices contain a growing part of
//! the energy (Brito and Ernst, Europhys. Lett. 43 (1998) 497).
//! Tolerance: 5 % of 1/tau. N w0 tau/4 = 1e4 collisions per run cause a scatter of 1 %; a contact lasts 1 % of the time
//! between collisions.
//! Control: discs with e = 0.97 and elastic discs are rejected.

use crate::scene::{frame, restitution, run_to_time, shipped};
use kinetoscope_manifest::model::DemConfig;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::DemTemperature;
use std::f64::consts::PI;

const FRAMES: u32 = 12;

fn temperature(model: &Dem) -> f64 {
    let temperature: DemTemperature = frame(model).get().expect("a temperature");
    temperature.granular_temperature_m2_per_s2
}

/// 1/tau from a least-squares fit of sqrt(T0/T) - 1 = t/tau, over the value of Haff's law.
fn cooling_rate_ratio(config: &DemConfig, seed: Seed, e: f64) -> f64 {
    let mut model = Dem::prepare(config, seed, false).unwrap_or_else(|error| panic!("{error}"));
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
    let pair_correlation = (1.0 - 7.0 / 16.0 * fraction) / ((1.0 - fraction) * (1.0 - fraction));
    let pair_collision_rate_per_disc =
        2.0 * PI.sqrt() * density * 2.0 * radius * pair_correlation * first.sqrt();
    products / squares / ((1.0 - e * e) * pair_collision_rate_per_disc / 4.0)
}

#[test]
fn cooling_rate_follows_haffs_law() {
    let runs = shipped("dem_granular_gas");
    let rates: Vec<f64> = runs
        .iter()
        .take(3)
        .map(|(_, config, seed)| cooling_rate_ratio(config, *seed, 0.95))
        .collect();
    let mean = rates.iter().sum::<f64>() / 3.0;
    println!("1/tau over Haff's value: {rates:.4?}, mean {mean:.4}");
    assert!((mean - 1.0).abs() < 0.05, "{mean}");
}

#[test]
fn control_different_restitution_is_rejected() {
    let (_, config, seed) = shipped("dem_granular_gas").swap_remove(0);
    for e in [0.97, 1.0] {
        let config = DemConfig { dissipation: restitution(e), ..config.clone() };
        let rate = cooling_rate_ratio(&config, seed, 0.95);
        println!("e = {e}: {rate:.4} of Haff's rate for 0.95");
        assert!((rate - 1.0).abs() > 0.05);
    }
}
