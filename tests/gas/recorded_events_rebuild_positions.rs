//! Law: discs fly straight between their collisions, so that a frame and the collisions after it, as `/events` records them, give the
//! position and the velocity of each disc at any time until the next frame.
//!
//! Source: free flight; the momentum of two discs is conserved in a collision.
//! Setup: 100 discs of masses 1 : 3 in a circle of radius 1 m; another run is observed at 1000 times whose distance has no common
//! measure with that of the frames.
//! Tolerance: 1e-12 m and 1e-12 m/s, some 4,000 roundings of a coordinate.
//! Control: without the collisions between the frame and the time, discs are elsewhere.

// Values written in a test are in range.
#![allow(clippy::unwrap_used)]

use crate::runs::{advance, channel, count, gas, max_speed, particles, positive};
use kinetoscope_manifest::model::{GasConfig, SpeedDistribution};
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::gas::motion::{Particle, drifted};
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::GasEvents;

const SEED: u64 = 8;
const FRAMES: u32 = 10;
const TIMES: u32 = 1000;
const FRAME_S: f64 = 0.5;
const TOLERANCE: f64 = 1e-12;

fn config() -> GasConfig {
    let config = GasConfig {
        particles: count(100),
        speed_distribution: SpeedDistribution::Equal,
        speed_scale: max_speed(1.0),
        disc_radius_m: Some(positive(0.03)),
        duration_s: positive(10.0),
        ..GasConfig::default()
    };
    let heavy = positive(3.0 * config.mass_kg.get());
    GasConfig { additional_masses_kg: vec![heavy], ..config }
}

/// Largest difference of a coordinate or a component of velocity.
fn difference(one: &[Particle], other: &[Particle]) -> f64 {
    let pairs = one.iter().zip(other).flat_map(|(one, other)| {
        let numbers = |it: &Particle| [it.position, it.velocity].concat();
        numbers(one).into_iter().zip(numbers(other)).collect::<Vec<_>>()
    });
    pairs
        .map(|(one, other)| (one - other).abs())
        .fold(0.0, |most, next| if next > most { next } else { most })
}

/// The particles of a frame at a later time, by the collisions until then.
fn rebuilt(
    frame: &[Particle],
    from_s: f64,
    to_s: f64,
    events: &GasEvents,
    masses_kg: &[f64],
) -> Vec<Particle> {
    let mut flights: Vec<_> = frame.iter().map(|particle| (*particle, from_s)).collect();
    for event in (0..events.event.len()).take_while(|event| events.time_s[*event] <= to_s) {
        let ids = [events.first_id[event] as usize, events.second_id[event] as usize];
        let impulse = [events.impulse_x_n_s[event], events.impulse_y_n_s[event]];
        let normal = [events.normal_x[event], events.normal_y[event]];
        assert!((normal[0] * impulse[1] - normal[1] * impulse[0]).abs() < TOLERANCE * masses_kg[1]);
        let turns = ids.into_iter().zip([1.0, -1.0]).take(if ids[0] == ids[1] { 1 } else { 2 });
        for (id, sign) in turns {
            let (particle, since_s) = flights[id];
            let mut now = drifted(particle, events.time_s[event] - since_s);
            for (component, change) in now.velocity.iter_mut().zip(impulse) {
                *component += sign * change / masses_kg[id % masses_kg.len()];
            }
            flights[id] = (now, events.time_s[event]);
        }
    }
    flights.iter().map(|(particle, since_s)| drifted(*particle, to_s - since_s)).collect()
}

#[test]
fn frame_and_events_give_positions_at_any_time() {
    let config = config();
    let mut recorded = Gas::prepare(&config, Seed { seed: SEED, replicate: 0 }, true).unwrap();
    let mut observed = gas(&config, SEED);
    assert!(channel::<GasEvents>(&recorded).event.is_empty());
    let (mut observations, mut last, mut worst, mut controls) = (1, 0, 0.0, 0);
    for frame in 0..FRAMES {
        let (from_s, to_s) = (f64::from(frame) * FRAME_S, f64::from(frame + 1) * FRAME_S);
        let start = particles(&recorded);
        advance(&mut recorded, Target::Time(to_s));
        let events = channel::<GasEvents>(&recorded);
        assert!(events.event.iter().copied().eq((last + 1..).take(events.event.len())));
        last += events.event.len() as u64;
        let length_s = f64::from(FRAMES) * FRAME_S;
        while let time_s = f64::from(observations) * length_s / (f64::from(TIMES) + 0.5)
            && time_s <= to_s
            && observations <= TIMES
        {
            observations += 1;
            advance(&mut observed, Target::Time(time_s));
            let there = particles(&observed);
            let off =
                difference(&rebuilt(&start, from_s, time_s, &events, recorded.masses_kg()), &there);
            worst = if off > worst { off } else { worst };
            let none = GasEvents::default();
            let control = rebuilt(&start, from_s, time_s, &none, recorded.masses_kg());
            controls += u32::from(difference(&control, &there) > TOLERANCE);
        }
    }
    println!("{last} events, {} observations, largest difference {worst:e}", observations - 1);
    assert!(observations == TIMES + 1 && worst < TOLERANCE && last > 1000 && controls > TIMES / 2);
}
