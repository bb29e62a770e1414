//! Gas runs of the law tests, from a configuration to the contents of its frames.

// Not every test file uses every function; values written in a test are in range.
#![allow(clippy::unwrap_used)]

use kinetoscope_manifest::model::{
    BoltzmannConstant, GasConfig, GasPlacement, GivenState, SpeedDistribution, SpeedScale,
    TemperatureDefinition,
};
use kinetoscope_manifest::quantity::{Finite, NonNegative, Positive};
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::gas::motion::Particle;
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::Channel;
use kinetoscope_recording::frame::Frame;
use std::num::NonZeroU32;

/// Returns a gas in its initial state.
pub(crate) fn gas(config: &GasConfig, seed: u64) -> Gas {
    Gas::prepare(config, Seed { seed, replicate: 0 }, false).unwrap()
}

/// Returns the message that rejects a configuration.
pub(crate) fn rejection(config: &GasConfig) -> String {
    Gas::prepare(config, Seed { seed: 1, replicate: 0 }, false).unwrap_err().0.to_string()
}

/// Advances to a target in one call.
pub(crate) fn advance(gas: &mut Gas, target: Target) {
    assert_eq!(gas.advance(target, u64::MAX), Ok(Progress::Reached));
}

/// Returns the current frame.
pub(crate) fn frame(gas: &Gas) -> Frame {
    let mut frame = Frame::new();
    gas.observe(&mut frame);
    frame
}

/// Returns one channel of the current frame.
pub(crate) fn channel<C: Channel>(gas: &Gas) -> C {
    frame(gas).get().unwrap()
}

/// Returns the current particles, in absolute coordinates.
pub(crate) fn particles(gas: &Gas) -> Vec<Particle> {
    let frame = frame(gas);
    // With several masses, a row ends in its own.
    let columns = if gas.masses_kg().len() == 1 { 4 } else { 5 };
    let rows = frame.state().chunks_exact(columns);
    rows.map(|row| Particle { position: [row[0], row[1]], velocity: [row[2], row[3]] }).collect()
}

/// Returns a configuration of given particles, without speed scaling, in a circle of radius 1 around the origin.
pub(crate) fn given(particles: &[([f64; 2], [f64; 2])]) -> GasConfig {
    let finite = |vector: [f64; 2]| vector.map(|axis| Finite::new(axis).unwrap());
    GasConfig {
        particles: count(particles.len() as u32),
        placement: GasPlacement::Given(GivenState {
            positions_m: particles.iter().map(|particle| finite(particle.0)).collect(),
            velocities_m_per_s: particles.iter().map(|particle| finite(particle.1)).collect(),
        }),
        speed_scale: SpeedScale::Given,
        duration_s: positive(1000.0),
        ..GasConfig::default()
    }
}

/// Returns the configuration of the gas exercise: uniform speeds, the temperature by the mean speed and `k_B` of 1986.
pub(crate) fn exercise() -> GasConfig {
    GasConfig {
        speed_distribution: SpeedDistribution::Uniform,
        temperature_definition: TemperatureDefinition::MeanSpeed,
        boltzmann_constant: BoltzmannConstant::Codata1986,
        ..GasConfig::default()
    }
}

/// Speed scale given by a temperature, K.
pub(crate) fn kelvin(temperature: f64) -> SpeedScale {
    SpeedScale::Temperature(NonNegative::new(temperature).unwrap())
}

/// Speed scale given by the maximum speed, m/s.
pub(crate) fn max_speed(speed: f64) -> SpeedScale {
    SpeedScale::MaxSpeed(NonNegative::new(speed).unwrap())
}

pub(crate) fn positive(value: f64) -> Positive {
    Positive::new(value).unwrap()
}

pub(crate) fn count(particles: u32) -> NonZeroU32 {
    NonZeroU32::new(particles).unwrap()
}

/// Returns the largest difference of components.
pub(crate) fn max_difference(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (x, y) = ((a[0] - b[0]).abs(), (a[1] - b[1]).abs());
    if x > y { x } else { y }
}
