//! Law: when the partition is removed, the temperature stays constant and the entropy grows by N k_B ln(A/A_left), or for two species by
//! -N k_B sum of x ln x.
//!
//! Source: free expansion (Joule, Phil. Mag. 26 (1845) 369) and entropy of mixing (Gibbs 1876) of ideal gases.
//! Setup: 10000 points, a partition through the center that is removed at 0.01 s; about 360 crossings of the circle later, the
//! particles on each side of it are counted.
//! Tolerance: the sides are counted with a standard error of sqrt(N)/2, four of which are 200 particles; temperature 1e-12.
//! Control: behind a partition that stays, the entropy does not change.

// Tests compare with the platform's functions and do not affect recorded bits.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::runs::{advance, channel, count, frame, gas, given, particles, positive};
use kinetoscope_manifest::model::{GasConfig, Partition, PartitionSide};
use kinetoscope_manifest::quantity::Finite;
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_recording::channels::{GasEnergyBalance, GasPressure, GasTemperature};

fn behind(x: f64, opens_s: Option<f64>, side: PartitionSide) -> GasConfig {
    GasConfig {
        particles: count(10_000),
        partition: Some(Partition {
            x_m: Finite::new(x).unwrap(),
            opens_s: opens_s.map(positive),
            side: Some(side),
        }),
        additional_masses_kg: match side {
            PartitionSide::Left => Vec::new(),
            PartitionSide::ByMass => vec![positive(4e-26)],
        },
        duration_s: positive(0.8),
        ..GasConfig::default()
    }
}

/// Number of particles of each species to the left of x.
fn on_the_left(gas: &Gas, x: f64) -> [usize; 2] {
    let all = particles(gas);
    [0, 1].map(|species| all.iter().skip(species).step_by(2).filter(|p| p.position[0] < x).count())
}

#[test]
fn temperature_is_constant_and_both_sides_fill() {
    let mut gas = gas(&behind(0.0, Some(0.01), PartitionSide::Left), 42);
    let mut max_change = 0.0;
    for (time, left) in
        [(0.0, Some(10_000)), (0.01 - 1e-9, Some(10_000)), (0.012, None), (0.8, None)]
    {
        advance(&mut gas, Target::Time(time));
        let [even, odd] = on_the_left(&gas, 0.0);
        let change = channel::<GasTemperature>(&gas).mean_square_temperature_k / 300.0 - 1.0;
        max_change = f64::max(max_change, change.abs());
        println!("{time} s: {} on the left", even + odd);
        assert!(left.is_none_or(|left| even + odd == left));
        assert!(left.is_some() || even + odd < 10_000);
    }
    println!("largest change of the temperature: {max_change:e}");
    assert!(max_change < 1e-12);
    let [even, odd] = on_the_left(&gas, 0.0);
    assert!((even + odd).abs_diff(5000) < 200);
    assert!(channel::<GasEnergyBalance>(&gas).residual_relative.abs() < 1e-12);
}

#[test]
fn two_species_mix() {
    let mut gas = gas(&behind(0.0, Some(0.01), PartitionSide::ByMass), 43);
    advance(&mut gas, Target::Time(0.0));
    assert_eq!(on_the_left(&gas, 0.0), [5000, 0]);
    advance(&mut gas, Target::Time(0.8));
    let left = on_the_left(&gas, 0.0);
    println!("on the left: {left:?}");
    assert!(left.iter().all(|left| left.abs_diff(2500) < 4 * 36));
}

#[test]
fn control_partition_that_stays_is_tight() {
    for (x, side) in
        [(0.0, PartitionSide::Left), (0.4, PartitionSide::ByMass), (-0.9, PartitionSide::ByMass)]
    {
        let mut gas = gas(&behind(x, None, side), 44);
        let first = on_the_left(&gas, x);
        for time in [0.01, 0.4, 0.8] {
            advance(&mut gas, Target::Time(time));
            assert_eq!(on_the_left(&gas, x), first, "{x} at {time} s");
        }
    }
}

/// A closed half is filled uniformly at the density N/(A/2), so the pressure on the arc, which is half of the wall, is twice that of
/// the whole container; averaged over the whole wall, it is the same.
#[test]
fn pressure_behind_the_partition_is_that_of_the_smaller_area() {
    let mut gas = gas(&behind(0.0, None, PartitionSide::Left), 45);
    advance(&mut gas, Target::Time(0.8));
    let ratio = channel::<GasPressure>(&gas).pressure_over_mean_square_formula;
    println!("mean over the wall, over the formula: {ratio}");
    assert!((ratio - 1.0).abs() < 0.01);
}

#[test]
fn partition_reflects_exactly() {
    // It starts at x = -0.5 and moves along y = 0 at 1 m/s: partition at x = 0.25, wall at x = -1.
    let mut config = given(&[([-0.5, 0.0], [1.0, 0.0])]);
    config.partition = Some(Partition {
        x_m: Finite::new(0.25).unwrap(),
        opens_s: Some(positive(4.5)),
        side: None,
    });
    let mut gas = gas(&config, 1);
    for (time, x) in [
        (0.5, 0.0),
        (1.0, 0.0),
        (2.0, -1.0),
        (3.0, 0.0),
        (4.0, -0.5),
        (5.5, -0.0),
        (6.0, 0.5),
        (7.0, 0.5),
    ] {
        advance(&mut gas, Target::Time(time));
        let position = particles(&gas)[0].position;
        assert!(
            (position[0] - x).abs() < 1e-13 && position[1].abs() < 1e-13,
            "{time}: {position:?}"
        );
    }
}

#[test]
fn saved_gas_continues_with_the_same_bits() {
    let config = behind(0.0, Some(0.01), PartitionSide::ByMass);
    let mut whole = gas(&config, 7);
    let mut half = gas(&config, 7);
    advance(&mut half, Target::Time(0.009));
    let mut half: Gas = serde_json::from_str(&serde_json::to_string(&half).unwrap()).unwrap();
    assert!(half.is_valid_for(&config));
    assert!(!half.is_valid_for(&behind(0.1, Some(0.01), PartitionSide::ByMass)), "control");
    for gas in [&mut whole, &mut half] {
        advance(gas, Target::Time(0.05));
    }
    assert_eq!(frame(&whole).state(), frame(&half).state());
}
