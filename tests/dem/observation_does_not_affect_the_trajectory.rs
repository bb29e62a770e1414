//! Promise: how work is cut, whether anybody looks, and whether the state was put away and taken up again, changes no bit
//! of the trajectory or of a frame.
//!
//! Setup: 60 discs of mixed radii in a small box, 2000 steps, frames each 500; every integrator.

use crate::scene::{SEED, frame, per_contact, positive, prepared};
use kinetoscope_manifest::model::{DemConfig, DemIntegrator, DiscRadius};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_recording::frame::Frame;
use std::num::NonZeroU32;

fn config(integrator: DemIntegrator) -> DemConfig {
    DemConfig {
        discs: NonZeroU32::new(60).expect("not zero"),
        radius_m: DiscRadius::Uniform { min: positive(3e-4), max: positive(7e-4) },
        width_m: positive(0.012),
        height_m: positive(0.012),
        time_step: per_contact(20.0),
        integrator,
        ..DemConfig::default()
    }
}

/// Frames at every 500 steps, with work cut by a budget; `between` may do something to the model between two cuts.
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

/// Bits, so that no rounding of a comparison hides anything.
fn bits(frames: &[Frame]) -> Vec<Vec<u64>> {
    frames.iter().map(|frame| frame.state().iter().map(|value| value.to_bits()).collect()).collect()
}

#[test]
fn cuts_looks_and_checkpoints_leave_no_trace() {
    for integrator in [
        DemIntegrator::SemiImplicitEuler,
        DemIntegrator::VelocityVerlet,
        DemIntegrator::ImplicitDashpot,
    ] {
        let config = config(integrator);
        let whole = frames(&config, u64::MAX, |model| model);
        let looked_at = frames(&config, 1, |model| {
            let _ = frame(&model);
            model
        });
        let put_away = frames(&config, 7, |model| {
            let stored = serde_json::to_value(&model).expect("a model can be stored");
            serde_json::from_value(stored).expect("and taken up again")
        });
        for other in [&looked_at, &put_away] {
            assert_eq!(bits(&whole), bits(other), "{integrator:?}");
            assert_eq!(&whole, other, "{integrator:?}: messages");
        }
        assert!(whole.last().is_some_and(|frame| !frame.contacts().is_empty()));
    }
}

#[test]
fn replicates_differ_and_the_time_step_does_not() {
    let config = config(DemIntegrator::SemiImplicitEuler);
    let other = kinetoscope_physics::random::Seed { replicate: 1, ..SEED };
    let other = Dem::prepare(&config, other, false).expect("a start");
    let model = prepared(&config);
    assert_ne!(bits(&[frame(&model)]), bits(&[frame(&other)]));
    assert_eq!(model.extent(), other.extent());
}
