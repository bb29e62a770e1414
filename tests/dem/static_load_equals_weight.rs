//! Law: a disc at rest on the floor overlaps it by m g/k, a column of discs by the weight that lies above.
//!
//! Source: k delta = m g, and Newton's third law.
//! Setup: discs laid down touching, left alone until the dashpots have taken all; every integrator and both tails.
//! Tolerance: 1e-9 of the overlap. The oscillation has died out; positions are rounded to 1e-18 m, the overlap is 2e-7 m.

use crate::scene::{discs, energy, frame, given, positive, prepared, restitution, run_to};
use kinetoscope_manifest::model::{DemConfig, DemIntegrator, ForceTail};
use kinetoscope_recording::channels::DemContacts;

const RADIUS: f64 = 5e-4;
const WEIGHT: f64 = 1e-3 * 9.81;

/// Overlaps from the floor upwards, over m g/k.
fn column(height: usize, tail: ForceTail, integrator: DemIntegrator) -> Vec<f64> {
    let places: Vec<_> =
        (0..height).map(|disc| ([0.02, RADIUS * (2 * disc + 1) as f64], [0.0, 0.0])).collect();
    let config = DemConfig {
        dissipation: restitution(0.3),
        force_tail: tail,
        integrator,
        ..DemConfig::default()
    };
    let mut model = prepared(&given(config, &places));
    run_to(&mut model, 6000);
    let rest = discs(&model);
    assert!(energy(&model).kinetic_j < 1e-25, "{:?}", energy(&model));
    let contacts: DemContacts = frame(&model).get().expect("contacts");
    assert_eq!((contacts.pair_contacts, contacts.wall_contacts), (height as u64 - 1, 1));
    let below = |disc: usize| {
        if disc == 0 { -RADIUS } else { rest[disc - 1].position[1] }
    };
    (0..height)
        .map(|disc| (2.0 * RADIUS - (rest[disc].position[1] - below(disc))) / (WEIGHT / 5e4))
        .collect()
}

#[test]
fn overlaps_carry_the_weight_above() {
    for tail in [ForceTail::Attractive, ForceTail::Clamped] {
        for integrator in [
            DemIntegrator::SemiImplicitEuler,
            DemIntegrator::VelocityVerlet,
            DemIntegrator::ImplicitDashpot,
        ] {
            for height in [1, 4] {
                for (disc, overlap) in column(height, tail, integrator).into_iter().enumerate() {
                    let expected = (height - disc) as f64;
                    assert!(
                        (overlap / expected - 1.0).abs() < 1e-9,
                        "{tail:?} {integrator:?}, disc {disc} of {height}: {overlap}"
                    );
                }
            }
        }
    }
}

/// Control: another stiffness is another overlap.
#[test]
fn another_stiffness_is_noticed() {
    let config = DemConfig { stiffness_n_per_m: positive(5.001e4), ..DemConfig::default() };
    let mut model = prepared(&given(config, &[([0.02, RADIUS], [0.0, 0.0])]));
    run_to(&mut model, 6000);
    let overlap = (RADIUS - discs(&model)[0].position[1]) / (WEIGHT / 5e4);
    assert!((overlap - 1.0).abs() > 1e-5, "{overlap}");
}
