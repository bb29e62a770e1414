//! Law: the kernel conserves the energy of another law, Hertz's contact, whose impacts follow their closed form.
//!
//! Source: Landau and Lifshitz, Theory of Elasticity, section 9: an impact at the speed v has the largest overlap
//! (5 m v^2/(4 kappa))^(2/5) and lasts 2.9433 times as long as that overlap over v. With a dashpot proportional to the root of the
//! stiffness, the restitution does not depend on the speed (Tsuji, Tanaka and Ishida 1992).
//! Setup: one disc and a wall, without gravity, and a bed of 40 discs; hundreds of steps per contact.
//! Tolerance: the method is of second order, so half the time step has a quarter of the energy error.
//! Control: the linear spring has another overlap and another duration.

// Tests compare with the platform's functions and do not affect recorded bits.
#![allow(clippy::disallowed_methods)]

use super::Law;
use super::hertz_contact::HertzContact;
use super::linear_spring::LinearSpring;
use crate::dem::Dem;
use crate::dem::energy::EnergyBalance;
use crate::model::{Model as _, Target};
use crate::random::Seed;
use kinetoscope_manifest::model::{DemConfig, ModelConfig};

/// kappa, N/m^(3/2): with it, an impact at 0.1 m/s has nearly the largest overlap.
const HERTZ: HertzContact = HertzContact { modulus: 2e6, largest_overlap: 5e-5 };

fn config(keys: &str) -> DemConfig {
    let manifest =
        format!("[model.dem]\nmass_kg = 1e-4\nradius_m = 1e-3\nduration_s = 1.0\n{keys}");
    let plan =
        kinetoscope_manifest::parse(&manifest, "m.toml", &[]).map_err(|errors| errors.to_string());
    match plan.unwrap().runs[0].manifest.model.clone() {
        ModelConfig::Dem(config) => config,
        _ => panic!("expected DEM"),
    }
}

/// A run with another law from its first step on.
fn run_with(law: Law, config: &DemConfig) -> Dem {
    let mut dem = Dem::prepare(config, Seed { seed: 1, replicate: 0 }, false).unwrap();
    dem.parameters.law.normal = law;
    // The lists contain the damping of each pair.
    dem.list_neighbors();
    dem.balance = EnergyBalance::default();
    dem.open_balance();
    dem
}

/// Time of the contact, s, largest overlap, m, and restitution of an impact of one disc on the floor.
fn impact(law: Law, speed: f64, restitution: f64) -> [f64; 3] {
    let keys = format!(
        "discs = 1\nwidth_m = 0.01\nheight_m = 0.01\ngravity_m_per_s2 = [0.0, 0.0]\ntime_step_s = 2e-7\nrestitution = {restitution}\n\
         limit_damping = false\nplacement = {{ positions_m = [[0.005, 0.00101]], velocities_m_per_s = [[0.0, -{speed}]] }}"
    );
    let mut dem = run_with(law, &config(&keys));
    let (mut steps, mut deepest) = (0, 0.0);
    while dem.discs.velocities[0][1] <= 0.0 || dem.discs.positions[0][1] < 1e-3 {
        dem.step().map_err(|_| "blow-up").unwrap();
        let overlap = 1e-3 - dem.discs.positions[0][1];
        steps += u32::from(overlap > 0.0);
        deepest = f64::max(deepest, overlap);
    }
    [f64::from(steps) * dem.parameters.time_step, deepest, dem.discs.velocities[0][1] / speed]
}

#[test]
fn impact_of_another_law_follows_its_closed_form() {
    let speed = 0.1;
    let linear =
        Law::LinearSpring(LinearSpring { stiffness: HERTZ.modulus * HERTZ.largest_overlap.sqrt() });
    let overlap = (5.0 * 1e-4 * speed * speed / (4.0 * HERTZ.modulus)).powf(0.4);
    let error = |law: Law| {
        let [duration, deepest, restitution] = impact(law, speed, 1.0);
        assert!((restitution - 1.0).abs() < 1e-3, "{restitution}");
        [duration * speed / overlap / 2.9433 - 1.0, deepest / overlap - 1.0].map(f64::abs)
    };
    let ([duration, deepest], other) = (error(Law::HertzContact(HERTZ)), error(linear));
    assert!(duration < 2e-3 && deepest < 1e-3);
    assert!(other.into_iter().all(|error| error > 0.02), "control");
}

#[test]
fn dashpot_of_another_law_gives_one_restitution_at_every_speed() {
    let [slow, fast] = [0.02, 0.1].map(|speed| impact(Law::HertzContact(HERTZ), speed, 0.7)[2]);
    assert!((slow / fast - 1.0).abs() < 2e-3 && (0.5..0.9).contains(&fast));
}

/// Largest error of the energy balance over all energy, at one step of ten.
fn energy_error(config: &DemConfig, duration: f64) -> f64 {
    let mut dem = run_with(Law::HertzContact(HERTZ), config);
    let (mut largest, mut contacts) = (0.0, 0);
    while dem.time() < duration {
        dem.advance(Target::Count(dem.count + 10), u64::MAX).unwrap();
        let evaluation = dem.evaluate();
        let (energies, balance) = dem.balance_of(&evaluation);
        largest = f64::max(largest, (balance.residual / energies.total()).abs());
        contacts += evaluation.contacts.pairs + evaluation.contacts.walls;
    }
    assert!(contacts > 0);
    largest
}

#[test]
fn energy_of_another_law_is_conserved_to_second_order() {
    let impact = |time_step: f64| {
        let keys = format!(
            "discs = 1\nwidth_m = 0.01\nheight_m = 0.01\ngravity_m_per_s2 = [0.0, 0.0]\ntime_step_s = {time_step}\nrestitution = 1.0\n\
             placement = {{ positions_m = [[0.005, 0.00101]], velocities_m_per_s = [[0.0, -0.1]] }}"
        );
        energy_error(&config(&keys), 5e-4)
    };
    let [coarse, fine] = [2e-6, 1e-6].map(impact);
    let bed = "discs = 40\nwidth_m = 0.02\nheight_m = 0.02\nrestitution = 1.0\ntime_step_s = 2e-6\nplacement = \"lattice\"\n\
        velocity_std_m_per_s = 0.05\n";
    let bed = energy_error(&config(bed), 0.04);
    assert!(coarse < 1e-3 && bed < 1e-3);
    assert!((3.0..5.0).contains(&(coarse / fine)), "{}", coarse / fine);
}

#[test]
fn another_law_has_the_same_bits_at_every_width() {
    for friction in [0.0, 0.4] {
        let keys = format!(
            "discs = 60\nwidth_m = 0.02\nheight_m = 0.02\nrestitution = 0.8\nfriction = {friction}\ntime_step_s = 2e-6\nplacement = \"lattice\"\n"
        );
        let state = |width: usize| {
            let mut dem = run_with(Law::HertzContact(HERTZ), &config(&keys)).with_max_width(width);
            dem.advance(Target::Time(0.04), u64::MAX).unwrap();
            dem.discs.positions.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<u64>>()
        };
        let scalar = state(1);
        assert!([4, 8].into_iter().all(|width| state(width) == scalar), "friction {friction}");
    }
}
