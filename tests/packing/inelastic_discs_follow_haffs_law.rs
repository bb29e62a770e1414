//! Law: while the system is homogeneous, T = T0 exp(-(1 - alpha^2) C / N) after C pair collisions. Three discs on a
//! line undergo inelastic collapse, infinitely many collisions in a finite time, if alpha < 7 - 4 sqrt(3) = 0.0718.
//!
//! Source: Haff, J. Fluid Mech. 134 (1983) 401: a collision dissipates (1 - alpha^2) g^2 / 4, and <g^2> = 4 kT;
//! McNamara and Young, Phys. Fluids A 4 (1992) 496.
//! Setup: stated at each test.
//! Tolerance: stated at each test.
//! Control: 1 - alpha instead of 1 - alpha^2 is rejected; elastic discs do not collapse.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods)]

use crate::runs::{
    advance_to_count, at_fraction, given, mean_and_standard_error, message, prepare,
    with_restitution,
};
use kinetoscope_manifest::model::{PackingConfig, PackingPlacement};
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_recording::channels::{PackingCollisions, PackingTemperature};

/// Setup: 500 discs at 0.1, 3 events per disc, 20 replicates.
/// Tolerance: 4.5 standard errors, and 1 % for a2 < 0, which reduces the rate of collisions with large g. The exponent
/// scatters by 4 % per replicate, 0.9 % for the mean, because C = 600 energy losses scatter by their own magnitude.
#[test]
fn temperature_follows_haffs_law() {
    for restitution in [0.95, 0.8] {
        let config = with_restitution(at_fraction(500, 0.1), restitution);
        let ratios: Vec<f64> = (0..20)
            .map(|replicate| {
                let mut packing = prepare(&config, 10, replicate);
                advance_to_count(&mut packing, 1500);
                let pairs = message::<PackingCollisions>(&packing).pair_collisions as f64;
                let ratio = message::<PackingTemperature>(&packing).temperature_over_initial;
                -ratio.ln() / ((1.0 - restitution * restitution) * pairs / 500.0)
            })
            .collect();
        let (mean, error) = mean_and_standard_error(&ratios);
        println!("alpha {restitution}: exponent over Haff's {mean:.4} +- {error:.4}");
        assert!((mean - 1.0).abs() < 4.5 * error + 0.01);
        // Control.
        let with_wrong_law = mean * (1.0 + restitution);
        assert!((with_wrong_law - 1.0).abs() > 4.5 * error + 0.01);
    }
}

fn three_on_a_line(restitution: f64) -> PackingConfig {
    let discs = [[-5.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0], [5.0, 0.0, -1.0, 0.0]];
    with_restitution(given(&discs), restitution)
}

/// Tolerance: none; alpha = 0.08 and 0.065 enclose the critical value.
#[test]
fn three_discs_on_a_line_collapse_below_the_critical_restitution() {
    for (restitution, collapses) in [(0.2, false), (0.08, false), (0.065, true), (0.01, true)] {
        let mut packing = prepare(&three_on_a_line(restitution), 0, 0);
        // The middle disc collides at time 3, and all further collisions follow at once, because both outer discs touch
        // it at 3.
        let outcome = packing.advance(Target::Time(4.0), u64::MAX);
        if collapses {
            let fault = outcome.unwrap_err();
            assert!(fault.recorded().starts_with("inelastic collapse at time 3"), "{fault}");
        } else {
            assert_eq!(outcome, Ok(Progress::Reached));
            println!("alpha {restitution}: {} collisions", packing.count());
        }
    }
}

#[test]
fn collapse_among_many_discs_is_a_fault() {
    let config = with_restitution(at_fraction(300, 0.4), 0.05);
    let mut packing = prepare(&config, 0, 0);
    let fault = packing.advance(Target::Time(1e6), u64::MAX).unwrap_err();
    assert!(fault.recorded().contains("inelastic collapse"), "{fault}");
    // The last state remains observable.
    assert!(message::<PackingTemperature>(&packing).temperature > 0.0);
}

/// Dense elastic discs, and discs that touch in the initial state, are not reported as a collapse.
#[test]
fn control_elastic_discs_do_not_collapse() {
    let dense = PackingConfig { placement: PackingPlacement::Lattice, ..at_fraction(400, 0.82) };
    advance_to_count(&mut prepare(&dense, 0, 0), 100_000);
    let row: Vec<[f64; 4]> = (0..19)
        .map(|index| [f64::from(2 * index) - 19.0, 0.0, f64::from(19 - index), 0.0])
        .collect();
    advance_to_count(&mut prepare(&given(&row), 0, 0), 10_000);
}
