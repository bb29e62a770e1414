//! Guarantee: the step budget, observation, and serialization of the model change no bit of the trajectory or of a frame.
//!
//! Setup: 60 discs of mixed radii in a small box, 2000 steps, one frame per 500 steps; every integrator.
//! Tolerance: none; the bits of the states and all messages are compared.
//! Control: another replicate has other bits.

use crate::scene::{SEED, frame, per_contact, positive, prepared};
use kinetoscope_manifest::model::{DemConfig, DemDashpot, DemIntegrator, DiscRadius};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_recording::frame::Frame;
use std::num::NonZeroU32;

fn config((integrator, dashpot): (DemIntegrator, DemDashpot)) -> DemConfig {
    DemConfig {
        discs: NonZeroU32::new(60).expect("not zero"),
        radius_m: DiscRadius::Uniform { min: positive(3e-4), max: positive(7e-4) },
        width_m: positive(0.012),
        height_m: positive(0.012),
        time_step: per_contact(20.0),
        integrator,
        dashpot,
        ..DemConfig::default()
    }
}

/// One frame per 500 steps, with a work budget per call; `between` is applied to the model after each incomplete call.
fn frames(config: &DemConfig, budget: u64, between: impl Fn(Dem) -> Dem) -> Vec<Frame> {
    let mut model = prepared(config);
    let mut frames = vec![frame(&model)];
    for target in [500, 1000, 1500, 2000] {
        loop {
            match model.advance(Target::Count(target), budget) {
                Ok(Progress::Reached) => break,
                Ok(Progress::Working) => model = between(model),
                Err(fault) => panic!("{fault}"),
            }
        }
        frames.push(frame(&model));
    }
    frames
}

/// Bits of the states, because a comparison of numbers does not distinguish signed zeros.
fn bits(frames: &[Frame]) -> Vec<Vec<u64>> {
    frames.iter().map(|frame| frame.state().iter().map(|value| value.to_bits()).collect()).collect()
}

#[test]
fn budget_observation_and_serialization_change_no_bit() {
    for integrator in [
        (DemIntegrator::SemiImplicitEuler, DemDashpot::Explicit),
        (DemIntegrator::VelocityVerlet, DemDashpot::Explicit),
        (DemIntegrator::SemiImplicitEuler, DemDashpot::Implicit),
        (DemIntegrator::VelocityVerlet, DemDashpot::Implicit),
    ] {
        let config = config(integrator);
        let reference = frames(&config, u64::MAX, |model| model);
        let observed = frames(&config, 1, |model| {
            let _ = frame(&model);
            model
        });
        let serialized = frames(&config, 7, |model| {
            let value = serde_json::to_value(&model).expect("a model can be serialized");
            serde_json::from_value(value).expect("a serialized model can be read")
        });
        for other in [&observed, &serialized] {
            assert_eq!(bits(&reference), bits(other), "{integrator:?}");
            assert_eq!(&reference, other, "{integrator:?}: messages");
        }
        assert!(reference.last().is_some_and(|frame| !frame.contacts().is_empty()));
    }
}

#[test]
fn replicates_differ_with_the_same_time_step() {
    let config = config((DemIntegrator::SemiImplicitEuler, DemDashpot::Explicit));
    let other = kinetoscope_physics::random::Seed { replicate: 1, ..SEED };
    let other = Dem::prepare(&config, other, false).expect("a valid configuration");
    let model = prepared(&config);
    assert_ne!(bits(&[frame(&model)]), bits(&[frame(&other)]));
    assert_eq!(model.extent(), other.extent());
}
