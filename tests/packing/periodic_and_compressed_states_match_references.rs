//! Laws of periodic boxes and of compressed initial states:
//! - Z = P A / (N kT) of the periodic fluid, from the virial and from the rate, Z = 1 + (sqrt(pi)/4) s w sqrt(m/kT),
//!   equals the reference;
//! - compression reaches packing fractions far above random placement, without overlap, and ends at the configured
//!   radius or pressure;
//! - the hexatic order |psi6| is high in the solid and low in the fluid;
//! - a periodic box conserves the momentum.
//!
//! Source: Z by independent programs, N = 1e4: 1.2362, 2.0633, 4.106, 8.406 at fractions 0.1, 0.3, 0.5, 0.65;
//! coexistence of liquid and hexatic at 0.700-0.716; Lubachevsky and Stillinger, J. Stat. Phys. 60 (1990) 561.
//! Setup: stated at each test.
//! Tolerance: stated at each test.
//! Control: stated at each test.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods)]

use crate::periodic_states::{hexatic_order, max_overlap, periodic, placed, pressures};
use crate::runs::{
    advance_to_count, at_fraction, disc_states, message, observe, prepare, with_restitution,
};
use kinetoscope_manifest::model::{Boundary, CollapseGuard, PackingConfig, PackingPlacement};
use kinetoscope_manifest::quantity::{NonNegative, Positive};
use kinetoscope_physics::model::{Model, SetupError};
use kinetoscope_physics::packing::Packing;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{PackingCollisions, PackingTemperature};
use std::cell::Cell;
use std::f64::consts::PI;

/// Setup: 2000 discs at four packing fractions.
/// Tolerance: 4 standard errors of blocks, and 0.2 % for 2000 discs instead of 10,000 (1/N).
/// Control: the second virial coefficient alone, Z = 1 + 2 f, is rejected.
#[test]
fn pressure_of_the_fluid_equals_the_reference() {
    for (fraction, known) in [(0.1, 1.23615), (0.3, 2.0633), (0.5, 4.106), (0.65, 8.406)] {
        let ([virial, virial_error], [rate, rate_error]) = pressures(2000, fraction, 20);
        println!(
            "fraction {fraction}: Z {virial:.4} +- {virial_error:.4} from the virial, {rate:.4} +- {rate_error:.4} from the \
             rate, reference {known}"
        );
        let slack = 0.002 * known;
        assert!((virial - known).abs() < 4.0 * virial_error + slack);
        assert!((rate - known).abs() < 4.0 * rate_error + slack);
        assert!((1.0 + 2.0 * fraction - known).abs() > 4.0 * virial_error + slack);
    }
}

/// Setup: 780 discs, 26 rows of 30, in a box where both sides fit within 1/1000; at 0.78 the crystal is stable, at 0.60
/// it melts.
/// Tolerance: |psi6| = 0.4, half of the crystal's value; that of the fluid is about N^-1/2 times the correlation
/// length, below 0.2.
#[test]
fn crystal_is_stable_above_coexistence_and_melts_below() {
    for (fraction, is_ordered) in [(0.78, true), (0.60, false)] {
        let config = periodic(placed(at_fraction(780, fraction), PackingPlacement::Lattice));
        let mut packing = prepare(&config, 4, 0);
        advance_to_count(&mut packing, 400_000);
        let order = hexatic_order(&disc_states(&packing), config.width.get());
        println!("fraction {fraction}: |psi6| {order:.3}");
        assert_eq!(order > 0.4, is_ordered);
    }
}

/// Setup: compression of a fluid up to 0.84, with walls and periodic, equal and mixed radii; checked at once and after
/// 30,000 events.
/// Tolerance: every disc has its radius, and no overlap exceeds 1e-12 of it.
/// Control: radii larger by 1e-9 are detected.
#[test]
fn compression_reaches_a_dense_state_without_overlap() {
    let dense = |fraction| placed(at_fraction(300, fraction), PackingPlacement::Compressed);
    let mixed = PackingConfig {
        radius_half_width: NonNegative::literal(0.2),
        compression_rate: Positive::literal(0.003),
        ..dense(0.8)
    };
    let slow = PackingConfig { compression_rate: Positive::literal(0.001), ..dense(0.84) };
    for config in [periodic(slow), dense(0.7), periodic(mixed)] {
        let mut packing = prepare(&config, 2, 0);
        println!("{}", observe(&packing).log_lines()[0].text);
        let side = if config.boundary == Boundary::Periodic { config.width.get() } else { 1e9 };
        let mut discs = disc_states(&packing);
        let covered: f64 = discs.iter().map(|disc| PI * disc.radius * disc.radius).sum();
        println!("fraction {}", covered / (config.width.get() * config.height.get()));
        for _ in 0..2 {
            let overlap = max_overlap(&discs, side);
            println!("largest overlap {overlap:e}");
            assert!(overlap < 1e-12);
            let half = 0.5 * config.width.get();
            for disc in &discs {
                let margin = if config.boundary == Boundary::Walls { disc.radius } else { 0.0 };
                assert!(disc.position.iter().all(|x| x.abs() <= half - margin + 1e-12));
            }
            advance_to_count(&mut packing, 30_000);
            discs = disc_states(&packing);
        }
        for disc in &mut discs {
            disc.radius += 1e-9;
        }
        let expected = 2e-9 + max_overlap(&disc_states(&packing), side);
        assert!((max_overlap(&discs, side) - expected).abs() < 1e-12);
    }
}

/// Setup: compression of 500 discs to Z = 8.
/// Tolerance: fraction 0.58 to 0.66. Growing discs are slightly out of equilibrium, and a window of 4 collisions per
/// disc scatters by a few percent.
#[test]
fn compression_ends_at_the_configured_pressure() {
    let config = PackingConfig {
        target_reduced_pressure: Some(Positive::literal(8.0)),
        ..periodic(placed(at_fraction(500, 0.8), PackingPlacement::Compressed))
    };
    let radius = disc_states(&prepare(&config, 2, 0))[0].radius;
    let fraction = 0.8 * radius * radius;
    println!("Z = 8 is reached at fraction {fraction:.3}; Z(0.6) = 6.45, Z(0.65) = 8.41");
    assert!(fraction > 0.58 && fraction < 0.66);
}

#[test]
fn impossible_compression_is_rejected() {
    let SetupError(message) = Packing::prepare(
        &placed(at_fraction(100, 0.905), PackingPlacement::Compressed),
        Seed { seed: 1, replicate: 0 },
        false,
    )
    .err()
    .unwrap();
    let text = message.to_string();
    println!("{text}");
    assert!(text.contains("compression reached") && text.contains("smaller radius"), "{text}");
}

/// Guarantee: a compression asks regularly whether to proceed, because the manifest bounds no number of its collisions.
/// Setup: ten discs that need 1e10 collisions per disc.
/// Control: the same discs at the default rate are compressed.
#[test]
fn slow_compression_can_be_stopped() {
    let discs = placed(at_fraction(10, 0.5), PackingPlacement::Compressed);
    let slow = PackingConfig { compression_rate: Positive::literal(1e-9), ..discs.clone() };
    let asked = Cell::new(0);
    let proceed = |_| {
        asked.set(asked.get() + 1);
        asked.get() < 20
    };
    let stopped = Packing::prepare_while(&slow, Seed { seed: 1, replicate: 0 }, false, &proceed);
    assert_eq!(stopped.err(), Some(SetupError::stopped()));
    assert_eq!(asked.get(), 20);
    prepare(&discs, 1, 0);
}

/// Setup: 1000 discs at 0.4, 2e5 collisions.
/// Tolerance: 1e-12 of the energy and 1e-10 for the momentum, for rounding.
#[test]
fn periodic_box_conserves_momentum_and_energy() {
    let config = periodic(at_fraction(1000, 0.4));
    let mut packing = prepare(&config, 9, 0);
    let energy = message::<PackingTemperature>(&packing).kinetic_energy;
    advance_to_count(&mut packing, 200_000);
    let after = message::<PackingTemperature>(&packing).kinetic_energy;
    assert!((after / energy - 1.0).abs() < 1e-12, "{:e}", after / energy - 1.0);
    assert_eq!(message::<PackingCollisions>(&packing).wall_collisions, 0);
    for axis in 0..2 {
        let momentum: f64 = disc_states(&packing).iter().map(|disc| disc.velocity[axis]).sum();
        assert!(momentum.abs() < 1e-10, "{momentum:e}");
    }
    assert!(max_overlap(&disc_states(&packing), config.width.get()) < 1e-12);
}

/// Setup: a state that collapses without a guard.
/// Control: without a guard, the run ends in a fault.
#[test]
fn guards_prevent_inelastic_collapse() {
    let unguarded = with_restitution(at_fraction(300, 0.4), 0.05);
    let advance = |guard| {
        let config = PackingConfig { collapse_guard: guard, ..unguarded.clone() };
        prepare(&config, 0, 0).advance(kinetoscope_physics::model::Target::Count(60_000), u64::MAX)
    };
    assert!(advance(CollapseGuard::Off).is_err());
    assert!(advance(CollapseGuard::ContactTime(Positive::literal(1e-4))).is_ok());
    assert!(advance(CollapseGuard::CutoffVelocity(Positive::literal(1e-3))).is_ok());
}
