//! Guarantee: every run of inelastic discs ends: with its last event, or with a fault when no event is left to wait for.
//!
//! Source: Haff, J. Fluid Mech. 134 (1983) 401: a pair collision takes (1 - alpha^2) of its energy, so <v^2> falls exponentially with
//! the number of events, and leaves the range of numbers.
//! Setup: stated at each test. A run with more than 2e7 collisions and cell crossings counts as endless.
//! Tolerance: none.
//! Control: elastic discs in the same box reach the last event.

#![allow(clippy::unwrap_used)] // An invalid configuration fails its test.

use crate::runs::{message, prepare, with_events_per_disc, with_restitution};
use kinetoscope_console::Explained as _;
use kinetoscope_manifest::model::{Boundary, ModelConfig, PackingConfig};
use kinetoscope_manifest::quantity::NonNegative;
use kinetoscope_physics::model::{Extent, Model, Progress, SimulationFault, Target};
use kinetoscope_physics::packing::Packing;
use kinetoscope_physics::restore;
use kinetoscope_recording::channels::PackingTemperature;
use kinetoscope_recording::checkpoint::Content as _;
use std::num::NonZeroU32;

/// Five times as many collisions and cell crossings as any of these runs takes to its end.
const ENDLESS: u64 = 20_000_000;

/// Collisions and cell crossings per call, more than the walls' runs have.
const AT_ONCE: u64 = 1_000_000;

fn twenty_discs(boundary: Boundary, restitution: f64, events_per_disc: u32) -> PackingConfig {
    let config = PackingConfig {
        discs: NonZeroU32::new(20).unwrap(),
        wall_noise_variance_rad2: NonNegative::literal(0.1),
        remove_mean_velocity: false,
        boundary,
        ..PackingConfig::default()
    };
    with_restitution(with_events_per_disc(config, events_per_disc), restitution)
}

/// The run at its end, advanced by a number of collisions and cell crossings per call.
fn end_of(config: PackingConfig, at_most: u64) -> (Packing, Result<Progress, SimulationFault>) {
    let mut packing = prepare(&config, 1, 0);
    let Extent::Events(events) = packing.extent() else { panic!("the run counts events") };
    let mut ends = (0..ENDLESS / at_most).map(|_| packing.advance(Target::Count(events), at_most));
    let end = ends.find(|end| *end != Ok(Progress::Working));
    (packing, end.expect("the run does not end"))
}

/// Setup: noisy walls; the energy falls below the smallest number after about 8,000 events per disc.
#[test]
fn discs_that_cool_between_noisy_walls_come_to_rest() {
    let (packing, end) = end_of(twenty_discs(Boundary::Walls, 0.9, 10_000), AT_ONCE);
    let fault = end.unwrap_err();
    assert!(fault.recorded().starts_with("the discs have come to rest after"), "{fault}");
    let is_short = |word: &&str| word.len() <= "1.23456e-123".len() && !word.ends_with("e0");
    let mut numbers =
        fault.recorded().split([' ', ',', ';']).filter(|word| word.parse::<f64>().is_ok());
    assert!(numbers.all(|number| is_short(&number)), "{fault}");
    assert!(fault.help().is_some());
    // The last state has all its digits.
    let temperature = message::<PackingTemperature>(&packing);
    assert!(temperature.mean_square_velocity < 1e-139 && temperature.mean_square_velocity > 1e-142);
    assert!((-1.0..20.0).contains(&temperature.a2), "{temperature:?}");
    let (_, control) = end_of(twenty_discs(Boundary::Walls, 1.0, 10_000), AT_ONCE);
    assert_eq!(control, Ok(Progress::Reached));
}

/// Setup: a periodic box, whose discs keep their mean velocity, so that at last all move in parallel. The fault does not depend on how
/// the work is divided.
#[test]
fn discs_that_move_in_parallel_end_the_run() {
    let config = twenty_discs(Boundary::Periodic, 0.9, 150);
    let (packing, end) = end_of(config.clone(), AT_ONCE);
    let fault = end.unwrap_err();
    assert!(fault.recorded().starts_with("event 3000 cannot be reached"), "{fault}");
    assert!(fault.recorded().contains("all move in parallel"), "{fault}");
    let (divided, again) = end_of(config, 1009);
    assert_eq!(again.unwrap_err(), fault);
    assert_eq!(
        (divided.time().to_bits(), divided.count()),
        (packing.time().to_bits(), packing.count())
    );
    let (_, control) = end_of(twenty_discs(Boundary::Periodic, 1.0, 150), AT_ONCE);
    assert_eq!(control, Ok(Progress::Reached));
}

/// Guarantee: a checkpoint of discs at rest resumes to the fault.
/// Control: one of discs that move continues.
#[test]
fn checkpoint_of_discs_at_rest_resumes_to_the_fault() {
    let config = twenty_discs(Boundary::Walls, 0.9, 10_000);
    let resumed = |packing: &Packing| {
        let mut bytes = Vec::new();
        packing.encode_into(&mut bytes).unwrap();
        let mut restored = restore(&ModelConfig::Packing(config.clone()), &bytes).unwrap();
        restored.advance(Target::Count(u64::MAX), 1)
    };
    let (at_rest, fault) = end_of(config.clone(), AT_ONCE);
    assert_eq!(resumed(&at_rest).unwrap_err().recorded(), fault.unwrap_err().recorded());
    assert_eq!(resumed(&prepare(&config, 1, 0)), Ok(Progress::Working));
}
