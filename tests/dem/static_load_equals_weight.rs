//! Law: k delta = m g for a disc at rest on the floor; in a column of discs, k delta equals the weight above each contact.
//!
//! Source: equilibrium of forces, and Newton's third law.
//! Setup: columns of one and four touching discs, which oscillate until the dashpots have dissipated all energy; every
//! integrator, both tails.
//! Tolerance: 1e-9 of the overlap. The oscillation has decayed; positions are rounded to 1e-18 m, and the overlap is 2e-7 m.
//! Control: a stiffness that differs by 2e-5 changes the overlap by more than 1e-5.

use crate::scene::{discs, energy, frame, given, prepared, restitution, run_to, spring};
use kinetoscope_manifest::model::{DemConfig, DemDashpot, DemIntegrator};
use kinetoscope_recording::channels::DemContactStatistics;

const RADIUS: f64 = 5e-4;
const WEIGHT: f64 = 1e-3 * 9.81;

/// Overlaps from the floor upwards, in units of m g/k.
fn column(
    height: usize,
    tail: bool,
    (integrator, dashpot): (DemIntegrator, DemDashpot),
) -> Vec<f64> {
    let start: Vec<_> =
        (0..height).map(|disc| ([0.02, RADIUS * (2 * disc + 1) as f64], [0.0, 0.0])).collect();
    let config = DemConfig {
        dissipation: restitution(0.3),
        limit_damping: tail,
        integrator,
        dashpot,
        ..DemConfig::default()
    };
    let mut model = prepared(&given(config, &start));
    run_to(&mut model, 6000);
    let rest = discs(&model);
    assert!(energy(&model).kinetic_j < 1e-25, "{:?}", energy(&model));
    let contacts: DemContactStatistics = frame(&model).get().expect("contact statistics");
    assert_eq!((contacts.pair_contacts, contacts.wall_contacts), (height as u64 - 1, 1));
    let below = |disc: usize| {
        if disc == 0 { -RADIUS } else { rest[disc - 1].position[1] }
    };
    (0..height)
        .map(|disc| (2.0 * RADIUS - (rest[disc].position[1] - below(disc))) / (WEIGHT / 5e4))
        .collect()
}

#[test]
fn overlap_carries_the_weight_above() {
    for tail in [false, true] {
        for integrator in [
            (DemIntegrator::SemiImplicitEuler, DemDashpot::Explicit),
            (DemIntegrator::VelocityVerlet, DemDashpot::Explicit),
            (DemIntegrator::SemiImplicitEuler, DemDashpot::Implicit),
            (DemIntegrator::VelocityVerlet, DemDashpot::Implicit),
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

#[test]
fn control_different_stiffness_is_rejected() {
    let config = DemConfig { elasticity: spring(5.001e4), ..DemConfig::default() };
    let mut model = prepared(&given(config, &[([0.02, RADIUS], [0.0, 0.0])]));
    run_to(&mut model, 6000);
    let overlap = (RADIUS - discs(&model)[0].position[1]) / (WEIGHT / 5e4);
    assert!((overlap - 1.0).abs() > 1e-5, "{overlap}");
}
