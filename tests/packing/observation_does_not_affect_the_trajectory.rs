//! Promises: a run's bits depend neither on how its work is cut, nor on how often it is looked at, nor on whether it was
//! stored and continued; a run by events ends after exactly the events that were asked for, a run by time at that time.
//! Judged by equality of every number, never by tolerance.

use crate::runs::{
    advance_to_count, advance_to_end, advance_to_time, at_fraction, given, look, message, observe,
    prepare, prepare_with_series, with_duration, with_events_per_disc, with_restitution,
};
use kinetoscope_manifest::model::PackingConfig;
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::packing::Packing;
use kinetoscope_recording::channels::{PackingCollisions, PackingTemperature, PerCollision};

fn config() -> PackingConfig {
    with_restitution(at_fraction(60, 0.3), 0.95)
}

#[test]
fn how_work_is_cut_changes_nothing() {
    let mut whole = prepare(&config(), 5, 0);
    advance_to_count(&mut whole, 3000);
    for budget in [1, 7, 1000] {
        let mut cut = prepare(&config(), 5, 0);
        while cut.advance(Target::Count(3000), budget) == Ok(Progress::Working) {}
        assert_eq!(cut, whole, "budget {budget}");
    }
}

#[test]
fn looking_changes_nothing_that_follows() {
    let mut alone = prepare(&config(), 5, 0);
    advance_to_count(&mut alone, 3000);
    let mut watched = prepare(&config(), 5, 0);
    let mut time = 0.0;
    while watched.time() < 0.9 * alone.time() {
        time += 0.01;
        advance_to_time(&mut watched, time);
        assert_eq!(watched.time(), time);
        assert_eq!(look(&watched).len(), 60);
    }
    advance_to_count(&mut watched, 3000);
    assert_eq!(watched.time(), alone.time());
    assert_eq!(observe(&watched).state(), observe(&alone).state());
    assert_eq!(watched, alone);
}

#[test]
fn a_stored_run_goes_on_as_if_nothing_had_been() {
    let mut whole = prepare(&config(), 5, 0);
    for stop in [0, 1, 100, 2000] {
        advance_to_count(&mut whole, stop);
        let stored = serde_json::to_value(&whole).unwrap();
        let mut restored: Packing = serde_json::from_value(stored).unwrap();
        assert_eq!(restored, whole);
        let mut unbroken = whole.clone();
        advance_to_count(&mut restored, 2500);
        advance_to_count(&mut unbroken, 2500);
        assert_eq!(restored, unbroken);
    }
}

#[test]
fn a_run_ends_after_exactly_its_events() {
    for discs in [1, 2, 5, 50] {
        let config = with_events_per_disc(at_fraction(discs, 0.1), 100);
        let mut packing = prepare(&config, 5, 0);
        assert_eq!(packing.extent(), Extent::Events(u64::from(100 * discs)));
        advance_to_end(&mut packing);
        let collisions = message::<PackingCollisions>(&packing);
        assert_eq!(packing.count(), u64::from(100 * discs));
        assert_eq!(collisions.pair + collisions.wall, packing.count());
        assert!(discs == 1 || collisions.pair > 0);
    }
}

#[test]
fn a_run_by_time_ends_there_and_has_seen_all_events_before() {
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

/// Discs at rest: time passes, no event comes; the two ends are both defined.
#[test]
fn discs_at_rest_stay_and_an_event_that_never_comes_is_a_fault() {
    let mut packing = prepare(&given(&[[0.0, 0.0, 0.0, 0.0], [5.0, 5.0, 0.0, 0.0]]), 0, 0);
    advance_to_time(&mut packing, 10.0);
    assert_eq!((packing.time(), packing.count()), (10.0, 0));
    let temperature = message::<PackingTemperature>(&packing);
    assert_eq!((temperature.temperature, temperature.a2), (0.0, 0.0));
    let fault = packing.advance(Target::Count(1), u64::MAX).unwrap_err();
    assert!(fault.0.contains("event 1 never comes"), "{fault}");
    assert!(packing.scenery().speed_range_top > 0.0);
}

/// The series has every event once, the start included, and says after each what a frame taken there says: T to 1e-13 and
/// a2 to 1e-12, the rounding of n small changes.
#[test]
fn the_series_of_every_collision_is_what_frames_say() {
    let mut packing = prepare_with_series(&config(), 5);
    let mut all = message::<PerCollision>(&packing);
    assert_eq!((all.event.as_slice(), all.time.as_slice()), ([0].as_slice(), [0.0].as_slice()));
    for frame in 1..=10_u64 {
        while packing.advance(Target::Count(300 * frame), 11) == Ok(Progress::Working) {}
        let window = message::<PerCollision>(&packing);
        assert_eq!(window.event.len(), 300);
        all.event.extend(window.event);
        all.time.extend(window.time);
        all.temperature.extend(window.temperature);
        all.a2.extend(window.a2);
    }
    assert_eq!(all.event, (0..=3000).collect::<Vec<u64>>());
    assert!(all.time.is_sorted());

    let mut single = prepare(&config(), 5, 0);
    for event in 0..=3000_usize {
        advance_to_count(&mut single, event as u64);
        let temperature = message::<PackingTemperature>(&single);
        assert_eq!(single.time(), all.time[event]);
        assert!((all.temperature[event] / temperature.temperature - 1.0).abs() < 1e-13);
        assert!((all.a2[event] - temperature.a2).abs() < 1e-12);
    }
    assert!(observe(&single).get::<PerCollision>().is_none());
}
