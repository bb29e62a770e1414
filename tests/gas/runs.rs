//! Gas runs for the law tests: from a configuration to what its frames say.

// Each test file takes what it needs; what is written in a test is in range, or the test is wrong.
#![allow(clippy::unwrap_used)]

use kinetoscope_manifest::model::{GasConfig, GivenState, Placement, SpeedScale};
use kinetoscope_manifest::quantity::{Finite, NonNegative, Positive};
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::gas::motion::Particle;
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::Channel;
use kinetoscope_recording::frame::Frame;
use std::num::NonZeroU32;

/// A gas at its start.
pub(crate) fn gas(config: &GasConfig, seed: u64) -> Gas {
    Gas::prepare(config, Seed { seed, replicate: 0 }, false).unwrap()
}

/// Why a configuration is refused.
pub(crate) fn refusal(config: &GasConfig) -> String {
    Gas::prepare(config, Seed { seed: 1, replicate: 0 }, false).unwrap_err().0
}

/// Moves to a target in one go.
pub(crate) fn advance(gas: &mut Gas, target: Target) {
    assert_eq!(gas.advance(target, u64::MAX), Ok(Progress::Reached));
}

/// The frame now.
pub(crate) fn frame(gas: &Gas) -> Frame {
    let mut frame = Frame::new();
    gas.observe(&mut frame);
    frame
}

/// One channel of the frame now.
pub(crate) fn channel<C: Channel>(gas: &Gas) -> C {
    frame(gas).get().unwrap()
}

/// The rows of the state now, absolute.
pub(crate) fn particles(gas: &Gas) -> Vec<Particle> {
    let frame = frame(gas);
    let rows = frame.state().chunks_exact(4);
    rows.map(|row| Particle { position: [row[0], row[1]], velocity: [row[2], row[3]] }).collect()
}

/// Particles written out, at the scale written, in a circle of radius 1 about the origin.
pub(crate) fn written(particles: &[([f64; 2], [f64; 2])]) -> GasConfig {
    let finite = |vector: [f64; 2]| vector.map(|axis| Finite::new(axis).unwrap());
    GasConfig {
        particles: count(particles.len() as u32),
        placement: Placement::Given(GivenState {
            positions: particles.iter().map(|particle| finite(particle.0)).collect(),
            velocities: particles.iter().map(|particle| finite(particle.1)).collect(),
        }),
        speed_scale: SpeedScale::Given,
        duration_s: positive(1000.0),
        ..GasConfig::default()
    }
}

/// A scale by temperature, K.
pub(crate) fn kelvin(temperature: f64) -> SpeedScale {
    SpeedScale::Temperature(NonNegative::new(temperature).unwrap())
}

/// A scale by the largest speed, m/s.
pub(crate) fn max_speed(speed: f64) -> SpeedScale {
    SpeedScale::MaxSpeed(NonNegative::new(speed).unwrap())
}

pub(crate) fn positive(value: f64) -> Positive {
    Positive::new(value).unwrap()
}

pub(crate) fn count(particles: u32) -> NonZeroU32 {
    NonZeroU32::new(particles).unwrap()
}

/// Largest difference of components.
pub(crate) fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (x, y) = ((a[0] - b[0]).abs(), (a[1] - b[1]).abs());
    if x > y { x } else { y }
}
