//! Laws of many hard discs in a periodic box, at the accuracy of their references. Each test takes up to two minutes in
//! a release build:
//!
//!     cargo test --release --test packing -- --ignored --nocapture reference_values
//!
//! - Z = P A / (N kT) of the fluid at seven fractions, from the virial and from the collision rate;
//! - a2 of the homogeneous cooling state at five restitutions;
//! - the hexatic order above and below the coexistence of liquid and hexatic at 0.700-0.716;
//! - no overlap and constant energy over 1e8 collisions.
//!
//! Source: Z by independent programs, N = 1e4, with their errors; a2 by direct simulation Monte Carlo, each +- 0.001.
//! Setup: stated at each test.
//! Tolerance: 3 combined standard errors of simulation and reference; 0.0015 more for a2.
//! Control: stated at each test.

// Assertions compare within tolerances, so no bit of a run depends on these functions; 0.7071 is the reference's
// restitution.
#![allow(clippy::disallowed_methods, clippy::approx_constant)]

use crate::periodic_states::{hexatic_order, max_overlap, periodic, placed, pressures};
use crate::runs::{
    advance_to_count, at_fraction, disc_states, mean_and_standard_error, message, prepare,
    with_restitution,
};
use kinetoscope_manifest::model::PackingPlacement;
use kinetoscope_recording::channels::{PackingCollisions, PackingTemperature};

/// Fraction, Z and its standard error.
const EQUATION_OF_STATE: [[f64; 3]; 7] = [
    [0.1, 1.23615, 0.00009],
    [0.2, 1.5702, 0.0002],
    [0.3, 2.0633, 0.0002],
    [0.4, 2.8288, 0.0004],
    [0.5, 4.106, 0.001],
    [0.6, 6.454, 0.002],
    [0.65, 8.406, 0.002],
];

/// Setup: blocks of 20 collisions per disc, longer than the correlation time of the stress; the first 30 are discarded,
/// so that the initial lattice has no effect.
/// Control: Z of a fraction larger by 1 % is rejected, by Henderson's derivative d ln Z / d ln f > 2 f.
#[test]
#[ignore = "a minute"]
fn full_harness_pressure_equals_the_reference_at_seven_fractions() {
    for [fraction, known, known_error] in EQUATION_OF_STATE {
        let (from_virial, from_rate) = pressures(10_000, fraction, 100);
        for (method, [value, error]) in [("virial", from_virial), ("rate", from_rate)] {
            let allowed = 3.0 * (error * error + known_error * known_error).sqrt();
            let deviation = 3.0 * (value - known) / allowed;
            println!(
                "fraction {fraction}: Z {value:.5} +- {error:.5} from the {method}, reference {known}: {deviation:+.1} errors"
            );
            assert!((value - known).abs() < allowed);
            let denser = known * (1.0 + 0.02 * fraction);
            assert!((value - denser).abs() > allowed, "control");
        }
    }
}

/// Setup: 10,000 discs at a fraction of 0.001, where velocities before a collision are independent and the box is 10
/// mean free paths wide, too small for the vortices that precede clusters. From Maxwell's distribution, a2 reaches its
/// value after 8 collisions per disc; the mean is over the next 8, and over 24 replicates.
/// Control: 0, Maxwell's value, is rejected where the reference differs enough.
#[test]
#[ignore = "a minute"]
fn full_harness_a2_of_the_cooling_state_equals_the_reference() {
    let discs = 10_000_u32;
    for (restitution, known) in
        [(0.95, -0.0207), (0.9, -0.0293), (0.8, -0.0265), (0.7071, -0.0040), (0.5, 0.0724)]
    {
        let config = periodic(with_restitution(at_fraction(discs, 0.001), restitution));
        let means: Vec<f64> = (0..24)
            .map(|replicate| {
                let mut packing = prepare(&config, 21, replicate);
                let samples = 8..=16_u64;
                let number = samples.clone().count() as f64;
                let sum: f64 = samples
                    .map(|collisions| {
                        advance_to_count(&mut packing, collisions * u64::from(discs) / 2);
                        message::<PackingTemperature>(&packing).a2
                    })
                    .sum();
                sum / number
            })
            .collect();
        let (mean, error) = mean_and_standard_error(&means);
        println!("alpha {restitution}: a2 {mean:.4} +- {error:.4}, reference {known}");
        let allowed = 0.0015 + 3.0 * error;
        assert!((mean - known).abs() < allowed);
        assert!(known.abs() < 2.0 * allowed || mean.abs() > allowed, "control");
    }
}

/// Setup: 3120 discs, 52 rows of 60, in a box where both sides fit within 1/1000, from the crystal. At 0.71, the value
/// is printed only.
#[test]
#[ignore = "a minute"]
fn full_harness_discs_are_ordered_above_coexistence_and_melt_below() {
    for (fraction, is_ordered) in [(0.73, Some(true)), (0.71, None), (0.69, Some(false))] {
        let config = periodic(placed(at_fraction(3120, fraction), PackingPlacement::Lattice));
        let mut packing = prepare(&config, 4, 0);
        let mut orders = Vec::new();
        for sample in 0..10_u64 {
            advance_to_count(&mut packing, 15_000_000 + sample * 500_000);
            orders.push(hexatic_order(&disc_states(&packing), config.width.get()));
        }
        let (order, error) = mean_and_standard_error(&orders);
        println!("fraction {fraction}: |psi6| {order:.3} +- {error:.3}");
        assert!(is_ordered.is_none_or(|ordered| ordered == (order > 0.4)));
    }
}

/// Setup: 1000 discs at 0.5, 100 frames.
/// Control: an overlap of 1e-9 is detected.
#[test]
#[ignore = "two minutes"]
fn full_harness_energy_is_conserved_without_overlap_in_a_hundred_million_collisions() {
    let config = periodic(placed(at_fraction(1000, 0.5), PackingPlacement::Lattice));
    let mut packing = prepare(&config, 5, 0);
    let start = message::<PackingTemperature>(&packing).kinetic_energy;
    let (mut overlap, mut drift) = (f64::NEG_INFINITY, 0.0_f64);
    for million in 1..=100 {
        advance_to_count(&mut packing, million * 1_000_000);
        overlap = overlap.max(max_overlap(&disc_states(&packing), config.width.get()));
        let energy = message::<PackingTemperature>(&packing).kinetic_energy;
        drift = drift.max((energy / start - 1.0).abs());
    }
    let pairs = message::<PackingCollisions>(&packing).pair_collisions;
    println!("{pairs} collisions: largest overlap {overlap:e}, energy {drift:e}");
    assert_eq!(pairs, 100_000_000);
    assert!(overlap < 1e-12 && drift < 1e-12);
    let mut discs = disc_states(&packing);
    let initial = max_overlap(&discs, config.width.get());
    for disc in &mut discs {
        disc.radius += 0.5 * (1e-9 - initial);
    }
    assert!(max_overlap(&discs, config.width.get()) > 1e-12, "control");
}
