//! Law: with friction, rolling friction, moving walls, periodic sides and discs that leave, kinetic + gravitational + elastic
//! + dissipated + removed - wall work stays constant but for the integrator's error, which falls with the time step.
//!
//! Source: conservation of energy. A spring with a slider loses exactly what its slip takes; a wall's work is its force times
//! its own way.
//! Setup: every scene of the promise of equal bits, 10,000 steps of N_t = 20 or the same time in 40,000 of N_t = 80.
//! Tolerance: the residual is below 2 % of the energy that was turned over at N_t = 20; at N_t = 80 it is smaller.

use crate::scene::{energy, frame, per_contact, prepared, run_to, scenes};
use kinetoscope_manifest::model::DemConfig;
use kinetoscope_recording::channels::{DemEnergy, DemWalls};

/// Energy that came, went or was turned over, J.
fn turnover(start: &DemEnergy, end: &DemEnergy) -> f64 {
    (end.gravitational_j - start.gravitational_j).abs() + end.dissipated_j + end.wall_work_j.abs()
}

/// Residual over turnover after a time, and the last ledger.
fn residual(config: &DemConfig, steps_per_contact: f64) -> (f64, DemEnergy, DemWalls) {
    let config = DemConfig { time_step: per_contact(steps_per_contact), ..config.clone() };
    let mut model = prepared(&config);
    let start = energy(&model);
    run_to(&mut model, (100.0 * steps_per_contact) as u64);
    let end = energy(&model);
    let walls: DemWalls = frame(&model).get().expect("walls");
    (end.residual_j.abs() / turnover(&start, &end), end, walls)
}

#[test]
fn every_joule_is_accounted_for() {
    for (name, config) in scenes() {
        let (coarse, end, walls) = residual(&config, 20.0);
        let (fine, ..) = residual(&config, 80.0);
        println!(
            "{name}: residual {coarse:.1e}, at N_t = 80 {fine:.1e}; friction {:.2e} J, rolling {:.2e} J, walls {:.2e} J, \
             removed {} discs with {:.2e} J",
            end.friction_j, end.rolling_j, end.wall_work_j, walls.discs_removed, end.removed_j
        );
        assert!(coarse < 2e-2, "{name}: {coarse}");
        assert!(fine < 0.5 * coarse, "{name}: {fine} and {coarse}");
    }
}

/// Control: without the terms of friction, walls or removed discs the ledger does not close.
#[test]
fn a_term_left_out_is_noticed() {
    let scenes = scenes();
    let broken = |name: &str, term: fn(&DemEnergy) -> f64| {
        let (_, config) = scenes.iter().find(|scene| scene.0 == name).expect("a scene");
        let (_, end, _) = residual(config, 20.0);
        (end.residual_j - term(&end)).abs() / (end.dissipated_j + end.wall_work_j.abs())
    };
    for (name, left_out) in [
        ("rubbing bed", broken("rubbing bed", |end| end.friction_j)),
        ("shaken box", broken("shaken box", |end| end.wall_work_j)),
        ("hopper", broken("hopper", |end| end.removed_j)),
    ] {
        println!("{name}: {left_out:.1e}");
        assert!(left_out > 2e-2, "{name}: {left_out}");
    }
}
