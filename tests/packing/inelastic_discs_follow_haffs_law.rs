//! Laws of inelastic discs: while the system stays homogeneous T falls as T0 exp(-(1 - alpha^2) C / N) with C pair
//! collisions; three discs on a line collapse, with infinitely many collisions in a finite time, where alpha is below
//! 7 - 4 sqrt(3) = 0.0718.
//! Source: Haff, J. Fluid Mech. 134, 401 (1983): a collision takes (1 - alpha^2) g^2 / 4 and <g^2> = 4 kT; McNamara and
//! Young, Phys. Fluids A 4, 496 (1992).

// A test judges within tolerances: no bit of a run depends on it.
#![allow(clippy::disallowed_methods)]

use crate::runs::{
    advance_to_count, at_fraction, given, mean_and_standard_error, message, prepare,
    with_restitution,
};
use kinetoscope_manifest::model::{PackingConfig, PackingPlacement};
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_recording::channels::{PackingCollisions, PackingTemperature};

/// Setup: 500 discs at 0.1, 3 events a disc, 20 replicates. The exponent's noise: C = 600 energy losses that scatter by
/// their own size give 4 % a replicate, 0.9 % in the mean. Tolerance: 4.5 standard errors, and 1 % for a2 < 0, which slows
/// collisions of large g. Control: 1 - alpha in place of 1 - alpha^2 is rejected.
#[test]
fn the_temperature_falls_by_haffs_law() {
    for restitution in [0.95, 0.8] {
        let config = with_restitution(at_fraction(500, 0.1), restitution);
        let ratios: Vec<f64> = (0..20)
            .map(|replicate| {
                let mut packing = prepare(&config, 10, replicate);
                advance_to_count(&mut packing, 1500);
                let pairs = message::<PackingCollisions>(&packing).pair as f64;
                let ratio = message::<PackingTemperature>(&packing).temperature_over_initial;
                -ratio.ln() / ((1.0 - restitution * restitution) * pairs / 500.0)
            })
            .collect();
        let (mean, error) = mean_and_standard_error(&ratios);
        println!("alpha {restitution}: exponent over Haff's {mean:.4} +- {error:.4}");
        assert!((mean - 1.0).abs() < 4.5 * error + 0.01);
        let with_wrong_law = mean * (1.0 + restitution);
        assert!((with_wrong_law - 1.0).abs() > 4.5 * error + 0.01);
    }
}

fn three_on_a_line(restitution: f64) -> PackingConfig {
    let discs = [[-5.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0], [5.0, 0.0, -1.0, 0.0]];
    with_restitution(given(&discs), restitution)
}

#[test]
fn three_discs_on_a_line_collapse_below_the_known_restitution_only() {
    for (restitution, collapses) in [(0.2, false), (0.08, false), (0.065, true), (0.01, true)] {
        let mut packing = prepare(&three_on_a_line(restitution), 0, 0);
        // The middle one is hit at 3, and all that follows happens at once: the outer two touch it at 3 as well.
        let outcome = packing.advance(Target::Time(4.0), u64::MAX);
        if collapses {
            let fault = outcome.unwrap_err();
            assert!(fault.0.starts_with("inelastic collapse at time 3"), "{fault}");
        } else {
            assert_eq!(outcome, Ok(Progress::Reached));
            println!("alpha {restitution}: {} collisions", packing.count());
        }
    }
}

#[test]
fn a_collapse_in_a_crowd_is_a_fault_and_not_an_endless_loop() {
    let config = with_restitution(at_fraction(300, 0.4), 0.05);
    let mut packing = prepare(&config, 0, 0);
    let fault = packing.advance(Target::Time(1e6), u64::MAX).unwrap_err();
    assert!(fault.0.contains("inelastic collapse"), "{fault}");
    // What led there can still be looked at.
    assert!(message::<PackingTemperature>(&packing).temperature > 0.0);
}

/// Control of the detector: dense elastic discs, and discs that touch at the start, are no collapse.
#[test]
fn elastic_discs_do_not_collapse() {
    let dense = PackingConfig { placement: PackingPlacement::Lattice, ..at_fraction(400, 0.82) };
    advance_to_count(&mut prepare(&dense, 0, 0), 100_000);
    let row: Vec<[f64; 4]> = (0..19)
        .map(|place| [f64::from(2 * place) - 19.0, 0.0, f64::from(19 - place), 0.0])
        .collect();
    advance_to_count(&mut prepare(&given(&row), 0, 0), 10_000);
}
