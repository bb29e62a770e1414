//! Guarantee: a run by events ends after exactly the configured number of events, and a run by time at the configured time; targets of
//! both kinds in between change no bit.
//!
//! Setup: 60 discs at fraction 0.3 with restitution 0.95; discs at rest; several numbers of discs.
//! Tolerance: none; every number is compared for equality, except for the series of collisions, where it is stated at
//! the test.

use crate::runs::{
    advance_to_count, advance_to_end, advance_to_time, at_fraction, disc_states, given, message,
    observe, prepare, prepare_with_series, with_duration, with_events_per_disc, with_restitution,
};
use kinetoscope_manifest::model::PackingConfig;
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::packing::Packing;
use kinetoscope_recording::channels::{
    PackingCollisions, PackingPressure, PackingTemperature, PerCollision,
};

fn config() -> PackingConfig {
    with_restitution(at_fraction(60, 0.3), 0.95)
}

#[test]
fn times_between_events_change_no_bit() {
    let mut unobserved = prepare(&config(), 5, 0);
    advance_to_count(&mut unobserved, 3000);
    let mut observed = prepare(&config(), 5, 0);
    let mut time = 0.0;
    while observed.time() < 0.9 * unobserved.time() {
        time += 0.01;
        advance_to_time(&mut observed, time);
        assert_eq!(observed.time(), time);
        assert_eq!(disc_states(&observed).len(), 60);
    }
    advance_to_count(&mut observed, 3000);
    assert_eq!(observed.time(), unobserved.time());
    assert_eq!(observe(&observed).state(), observe(&unobserved).state());
    assert_eq!(observed, unobserved);
}

#[test]
fn run_by_events_ends_after_exactly_its_events() {
    for discs in [1, 2, 5, 50] {
        let config = with_events_per_disc(at_fraction(discs, 0.1), 100);
        let mut packing = prepare(&config, 5, 0);
        assert_eq!(packing.extent(), Extent::Events(u64::from(100 * discs)));
        advance_to_end(&mut packing);
        let collisions = message::<PackingCollisions>(&packing);
        assert_eq!(packing.count(), u64::from(100 * discs));
        assert_eq!(collisions.pair_collisions + collisions.wall_collisions, packing.count());
        assert!(discs == 1 || collisions.pair_collisions > 0);
    }
}

#[test]
fn run_by_time_ends_at_its_time_after_all_earlier_events() {
    let mut by_time = prepare(&with_duration(config(), 12.5), 5, 0);
    assert_eq!(by_time.extent(), Extent::Time(12.5));
    advance_to_end(&mut by_time);
    assert_eq!(by_time.time(), 12.5);
    let mut by_count = prepare(&config(), 5, 0);
    advance_to_count(&mut by_count, by_time.count());
    assert!(by_count.time() <= 12.5);
    advance_to_count(&mut by_count, by_time.count() + 1);
    assert!(by_count.time() > 12.5);
}

/// Means over time have no value at time 0: a zero would be a wrong value and stretch the axes of plots.
#[test]
fn rates_and_pressure_of_the_start_are_not_numbers() {
    let measured = |packing: &Packing| {
        let collisions = message::<PackingCollisions>(packing);
        let pressure = message::<PackingPressure>(packing);
        [
            collisions.pair_collision_rate_per_disc,
            collisions.wall_collision_rate_per_disc,
            pressure.virial,
            pressure.wall,
            pressure.compressibility_factor,
        ]
    };
    let mut packing = prepare(&config(), 5, 0);
    assert_eq!(measured(&packing).map(f64::to_bits), [f64::NAN.to_bits(); 5]);
    advance_to_count(&mut packing, 1000);
    assert!(measured(&packing).iter().all(|value| *value > 0.0));
}

/// Time passes without events for discs at rest; both ends of a run are defined.
#[test]
fn discs_at_rest_stay_at_rest_and_a_missing_event_is_a_fault() {
    let mut packing = prepare(&given(&[[0.0, 0.0, 0.0, 0.0], [5.0, 5.0, 0.0, 0.0]]), 0, 0);
    advance_to_time(&mut packing, 10.0);
    assert_eq!((packing.time(), packing.count()), (10.0, 0));
    let temperature = message::<PackingTemperature>(&packing);
    assert_eq!((temperature.temperature, temperature.a2), (0.0, 0.0));
    let fault = packing.advance(Target::Count(1), u64::MAX).unwrap_err();
    assert!(fault.recorded().contains("event 1 cannot be reached"), "{fault}");
    assert!(packing.scenery().speed_range_top > 0.0);
}

/// The series contains every event once, including the initial state, with the values of a frame after that event.
/// Tolerance: 1e-13 for T and 1e-12 for a2, for the rounding of n small changes.
#[test]
fn collision_series_equals_frames_after_every_event() {
    let mut packing = prepare_with_series(&config(), 5);
    let mut all = message::<PerCollision>(&packing);
    assert_eq!((all.event.as_slice(), all.time.as_slice()), ([0].as_slice(), [0.0].as_slice()));
    for frame in 1..=10_u64 {
        while packing.advance(Target::Count(300 * frame), 11) == Ok(Progress::Working) {}
        let window = message::<PerCollision>(&packing);
        assert_eq!(window.event.len(), 300);
        all.event.extend(window.event);
        all.time.extend(window.time);
        all.mean_square_velocity.extend(window.mean_square_velocity);
        all.a2.extend(window.a2);
    }
    assert_eq!(all.event, (0..=3000).collect::<Vec<u64>>());
    assert!(all.time.is_sorted());

    let mut single = prepare(&config(), 5, 0);
    for event in 0..=3000_usize {
        advance_to_count(&mut single, event as u64);
        let temperature = message::<PackingTemperature>(&single);
        assert_eq!(single.time(), all.time[event]);
        assert!(
            (all.mean_square_velocity[event] / temperature.mean_square_velocity - 1.0).abs()
                < 1e-13
        );
        assert!((all.a2[event] - temperature.a2).abs() < 1e-12);
    }
    assert!(observe(&single).get::<PerCollision>().is_none());
}
