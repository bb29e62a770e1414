//! Configurations of hard discs, functions that advance a run, and frame readers.

#![allow(clippy::unwrap_used)] // An invalid configuration fails its test.

use kinetoscope_manifest::model::{
    PackingConfig, PackingObstacles, PackingPlacement, PackingState, RunLength,
};
use kinetoscope_manifest::quantity::{BoxSide, Finite, Fraction, NonNegative, Positive};
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::packing::Packing;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::Channel;
use kinetoscope_recording::frame::Frame;
use std::num::NonZeroU32;

/// One row of the recorded state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiscState {
    pub(crate) position: [f64; 2],
    pub(crate) velocity: [f64; 2],
    pub(crate) radius: f64,
}

/// Returns the configuration of the packing exercise: walls turn velocities by an angle of variance pi/1000, and the total
/// momentum at the start is zero.
pub(crate) fn exercise() -> PackingConfig {
    PackingConfig {
        wall_noise_variance_rad2: NonNegative::literal(std::f64::consts::PI / 1000.0),
        remove_mean_velocity: true,
        ..PackingConfig::default()
    }
}

/// Square box with a given packing fraction and the exercise's walls and velocities. The radius is 1, or larger if the side would be below the minimum of 10.
pub(crate) fn at_fraction(discs: u32, fraction: f64) -> PackingConfig {
    let side = (f64::from(discs) * std::f64::consts::PI / fraction).sqrt();
    let (side, radius) = if side < 10.0 { (10.0, 10.0 / side) } else { (side, 1.0) };
    PackingConfig {
        discs: NonZeroU32::new(discs).unwrap(),
        width: BoxSide::new(side).unwrap(),
        height: BoxSide::new(side).unwrap(),
        radius: Positive::new(radius).unwrap(),
        ..exercise()
    }
}

/// Discs of radius 1 in the default box, each given as `[x, y, vx, vy]`, without wall noise.
pub(crate) fn given(discs: &[[f64; 4]]) -> PackingConfig {
    let pair = |[x, y]: [f64; 2]| [Finite::new(x).unwrap(), Finite::new(y).unwrap()];
    PackingConfig {
        discs: NonZeroU32::new(discs.len() as u32).unwrap(),
        wall_noise_variance_rad2: NonNegative::literal(0.0),
        placement: PackingPlacement::Given(PackingState {
            positions: discs.iter().map(|&[x, y, _, _]| pair([x, y])).collect(),
            velocities: discs.iter().map(|&[_, _, vx, vy]| pair([vx, vy])).collect(),
        }),
        ..PackingConfig::default()
    }
}

pub(crate) fn with_obstacles(
    config: PackingConfig,
    centers: &[[f64; 2]],
    radius: f64,
) -> PackingConfig {
    let positions = centers.iter().map(|center| center.map(|part| Finite::new(part).unwrap()));
    let obstacles =
        PackingObstacles { positions: positions.collect(), radius: Positive::new(radius).unwrap() };
    PackingConfig { obstacles: Some(obstacles), ..config }
}

pub(crate) fn without_noise(config: PackingConfig) -> PackingConfig {
    PackingConfig { wall_noise_variance_rad2: NonNegative::literal(0.0), ..config }
}

pub(crate) fn with_restitution(config: PackingConfig, restitution: f64) -> PackingConfig {
    PackingConfig { restitution: Fraction::new(restitution).unwrap(), ..config }
}

pub(crate) fn with_events_per_disc(config: PackingConfig, events: u32) -> PackingConfig {
    PackingConfig { length: RunLength::EventsPerDisc(NonZeroU32::new(events).unwrap()), ..config }
}

pub(crate) fn with_duration(config: PackingConfig, duration: f64) -> PackingConfig {
    PackingConfig { length: RunLength::Duration(Positive::new(duration).unwrap()), ..config }
}

pub(crate) fn prepare(config: &PackingConfig, seed: u64, replicate: u32) -> Packing {
    Packing::prepare(config, Seed { seed, replicate }, false).unwrap()
}

pub(crate) fn prepare_with_series(config: &PackingConfig, seed: u64) -> Packing {
    Packing::prepare(config, Seed { seed, replicate: 0 }, true).unwrap()
}

pub(crate) fn advance_to_count(packing: &mut Packing, count: u64) {
    assert_eq!(packing.advance(Target::Count(count), u64::MAX), Ok(Progress::Reached));
}

pub(crate) fn advance_to_time(packing: &mut Packing, time: f64) {
    assert_eq!(packing.advance(Target::Time(time), u64::MAX), Ok(Progress::Reached));
}

/// Advances to the end given in the configuration.
pub(crate) fn advance_to_end(packing: &mut Packing) {
    match packing.extent() {
        Extent::Events(events) => advance_to_count(packing, events),
        Extent::Time(time) => advance_to_time(packing, time),
        Extent::Steps { .. } => panic!("hard discs have no steps"),
    }
}

pub(crate) fn observe(packing: &Packing) -> Frame {
    let mut frame = Frame::new();
    packing.observe(&mut frame);
    frame
}

pub(crate) fn message<C: Channel>(packing: &Packing) -> C {
    observe(packing).get::<C>().unwrap()
}

pub(crate) fn disc_states(packing: &Packing) -> Vec<DiscState> {
    let frame = observe(packing);
    frame
        .state()
        .chunks_exact(5)
        .map(|row| DiscState {
            position: [row[0], row[1]],
            velocity: [row[2], row[3]],
            radius: row[4],
        })
        .collect()
}

pub(crate) fn squared_speed(velocity: [f64; 2]) -> f64 {
    velocity[0] * velocity[0] + velocity[1] * velocity[1]
}

pub(crate) fn distance(first: [f64; 2], second: [f64; 2]) -> f64 {
    squared_speed([first[0] - second[0], first[1] - second[1]]).sqrt()
}

pub(crate) fn mean_and_standard_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
    (mean, (squares / (count - 1.0) / count).sqrt())
}
