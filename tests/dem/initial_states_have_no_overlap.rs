//! Guarantee: no run starts with overlapping discs or with discs outside the box. Discs that cannot be placed are
//! rejected with a remedy.
//!
//! Setup: random and lattice placement with equal and mixed radii, checked over all pairs; invalid given states.
//! Tolerance: touching discs do not overlap, up to 1e-12 of the radii for rounded decimals.
//! Control: given states with an overlap, with a disc outside the box or with a wrong number of discs are rejected.

use crate::scene::{SEED, discs, equal, frame, given, positive, prepared, run_to};
use kinetoscope_manifest::model::{DemConfig, DiscRadius, Placement};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{DemEnergy, DemEnergyPercent, DemWalls};
use kinetoscope_recording::frame::Level;
use std::num::NonZeroU32;

/// Message of the rejection.
fn rejection(config: &DemConfig) -> String {
    Dem::prepare(config, SEED, false).expect_err("rejected").0.to_string()
}

fn crowd(count: u32, placement: Placement, radius: DiscRadius) -> DemConfig {
    DemConfig {
        discs: NonZeroU32::new(count).expect("not zero"),
        radius_m: radius,
        placement,
        ..DemConfig::default()
    }
}

#[test]
fn placed_discs_do_not_overlap_and_are_inside_the_box() {
    let mixed = DiscRadius::Uniform { min: positive(3e-4), max: positive(6e-4) };
    for placement in [Placement::Random, Placement::Lattice] {
        for radius in [equal(5e-4), mixed] {
            let state = discs(&prepared(&crowd(800, placement.clone(), radius)));
            assert_eq!(state.len(), 800);
            for (index, disc) in state.iter().enumerate() {
                for axis in 0..2 {
                    assert!(disc.position[axis] >= disc.radius);
                    assert!(disc.position[axis] <= 0.04 - disc.radius);
                }
                for other in &state[index + 1..] {
                    let branch = [0, 1].map(|axis| disc.position[axis] - other.position[axis]);
                    let reach = (disc.radius + other.radius) * (1.0 - 1e-12);
                    assert!(branch[0] * branch[0] + branch[1] * branch[1] >= reach * reach);
                }
            }
        }
    }
}

#[test]
fn energy_balance_starts_at_zero_and_properties_are_logged() {
    let start = frame(&prepared(&DemConfig::default()));
    let energy: DemEnergy = start.get().expect("energy");
    assert_eq!((energy.residual_j, energy.dissipated_j, energy.elastic_j), (0.0, 0.0, 0.0));
    let messages: Vec<&str> = start
        .log_lines()
        .iter()
        .filter(|line| line.level == Level::Info)
        .map(|line| line.text.as_str())
        .collect();
    // N_t = 20 at zeta = 0.21545: 20/sqrt(2)/sqrt(1 - zeta^2) = 14.48 steps for a pair, 20.48 for a wall.
    for text in
        ["20 discs placed at random", "14.5 steps with each other, 20.5 with a wall", "c = "]
    {
        assert!(
            messages.iter().any(|message| message.contains(text)),
            "no {text:?} in {messages:?}"
        );
    }
}

/// Wall forces are means since the last frame, so the start has none. Energies of a few microjoules are recorded in percent of a
/// reference, whose unit keeps the digits few.
#[test]
fn wall_forces_of_the_start_are_not_numbers_and_the_reference_energy_is_in_microjoules() {
    let mut model = prepared(&DemConfig::default());
    let forces = |model: &Dem| {
        let walls: DemWalls = frame(model).get().expect("wall forces");
        [walls.mean_force_x_n, walls.mean_force_y_n].concat()
    };
    let nothing = f64::NAN.to_bits();
    assert!(forces(&model).iter().all(|force| force.to_bits() == nothing));
    let energy: DemEnergy = frame(&model).get().expect("energy");
    let percent: DemEnergyPercent = frame(&model).get().expect("energy in percent");
    assert!((percent.reference_energy_uj / (1e6 * energy.total_j) - 1.0).abs() < 1e-15);
    assert!(percent.reference_energy_uj > 0.1 && percent.reference_energy_uj < 1e6);
    run_to(&mut model, 10);
    assert!(forces(&model).iter().all(|force| force.is_finite()));
}

#[test]
fn too_many_discs_are_rejected() {
    // 1300 discs cover 64 % of the box: too many for random placement, fewer than the capacity of the lattice.
    assert!(rejection(&crowd(1300, Placement::Random, equal(5e-4))).contains("lattice"));
    assert_eq!(discs(&prepared(&crowd(1300, Placement::Lattice, equal(5e-4)))).len(), 1300);
    assert!(rejection(&crowd(1700, Placement::Lattice, equal(5e-4))).contains("fewer discs"));
    assert!(rejection(&crowd(1, Placement::Random, equal(0.021))).contains("no room"));
}

#[test]
fn invalid_given_states_are_rejected_and_touching_discs_accepted() {
    let at_rest = [0.0, 0.0];
    let start = |positions: &[[f64; 2]]| {
        let discs: Vec<_> = positions.iter().map(|&position| (position, at_rest)).collect();
        given(DemConfig::default(), &discs)
    };
    assert!(rejection(&start(&[[0.01, 0.01], [0.0109, 0.01]])).contains("discs 0 and 1"));
    assert!(rejection(&start(&[[0.01, 0.01], [0.0399, 0.01]])).contains("disc 1"));
    assert!(rejection(&start(&[[0.01, 0.0004]])).contains("disc 0"));
    let mismatch = DemConfig {
        discs: NonZeroU32::new(3).expect("not zero"),
        ..start(&[[0.01, 0.01], [0.02, 0.01]])
    };
    assert!(rejection(&mismatch).contains("discs = 3"));
    let touching = start(&[[0.0123, 0.0005], [0.0133, 0.0005], [0.0143, 0.0005]]);
    assert_eq!(discs(&prepared(&touching)).len(), 3);
}

/// Guarantee: replicates have other states and the same time step.
#[test]
fn replicates_differ_with_the_same_time_step() {
    let mixed = DiscRadius::Uniform { min: positive(3e-4), max: positive(7e-4) };
    let config = crowd(60, Placement::Random, mixed);
    let model = prepared(&config);
    let other = Dem::prepare(&config, Seed { replicate: 1, ..SEED }, false).expect("valid");
    assert_ne!(frame(&model).state(), frame(&other).state());
    assert_eq!(model.extent(), other.extent());
}
