//! Law: with friction, rolling friction, moving walls, periodic sides and discs that leave, kinetic + gravitational +
//! elastic + dissipated + removed - wall work is constant up to the integration error, which decreases with the time
//! step.
//!
//! Source: conservation of energy. A spring with a slider dissipates the work of its slip; the work of a wall is its
//! force times its own displacement.
//! Setup: every scene of `threads_and_simd_do_not_affect_results` for 2000 steps at N_t = 20, and for the same time,
//! 8000 steps, at N_t = 80.
//! Tolerance: the residual is below 2 % of the energy exchanged at N_t = 20, and falls by at least a factor of 2 at N_t
//! = 80, unless both are below 2e-5, where errors of single contacts cancel.
//! Control: a balance without the terms of friction, wall work or removed discs exceeds 2 %.

use crate::scene::{energy, frame, per_contact, prepared, run_to, scenes};
use kinetoscope_manifest::model::DemConfig;
use kinetoscope_recording::channels::{DemEnergy, DemWalls};

/// Energy exchanged, J.
fn turnover(start: &DemEnergy, end: &DemEnergy) -> f64 {
    (end.gravitational_j - start.gravitational_j).abs() + end.dissipated_j + end.wall_work_j.abs()
}

/// Residual over turnover after a time, and the last energy balance.
fn residual(config: &DemConfig, steps_per_wall_contact: f64) -> (f64, DemEnergy, DemWalls) {
    let config = DemConfig { time_step: per_contact(steps_per_wall_contact), ..config.clone() };
    let mut model = prepared(&config);
    let start = energy(&model);
    run_to(&mut model, (100.0 * steps_per_wall_contact) as u64);
    let end = energy(&model);
    let walls: DemWalls = frame(&model).get().expect("wall data");
    (end.residual_j.abs() / turnover(&start, &end), end, walls)
}

#[test]
fn energy_balance_closes_in_every_scene() {
    for (name, config) in scenes() {
        let (coarse, end, walls) = residual(&config, 20.0);
        let (fine, ..) = residual(&config, 80.0);
        println!(
            "{name}: residual {coarse:.1e}, at N_t = 80 {fine:.1e}; friction {:.2e} J, rolling {:.2e} J, walls {:.2e} J, \
             removed {} discs with {:.2e} J",
            end.friction_j, end.rolling_j, end.wall_work_j, walls.discs_removed, end.removed_j
        );
        assert!(coarse < 2e-2, "{name}: {coarse}");
        let cancels = coarse < 2e-5 && fine < 2e-5;
        assert!(fine < 0.5 * coarse || cancels, "{name}: {fine} and {coarse}");
    }
}

#[test]
fn control_missing_term_is_rejected() {
    let scenes = scenes();
    let incomplete = |name: &str, term: fn(&DemEnergy) -> f64| {
        let (_, config) = scenes.iter().find(|scene| scene.0 == name).expect("the scene exists");
        let (_, end, _) = residual(config, 20.0);
        (end.residual_j - term(&end)).abs() / (end.dissipated_j + end.wall_work_j.abs())
    };
    for (name, error) in [
        ("frictional bed", incomplete("frictional bed", |end| end.friction_j)),
        ("shaken box", incomplete("shaken box", |end| end.wall_work_j)),
        ("hopper", incomplete("hopper", |end| end.removed_j)),
    ] {
        println!("{name}: {error:.1e}");
        assert!(error > 2e-2, "{name}: {error}");
    }
}
