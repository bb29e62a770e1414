//! Short ways to set up discs, to run them and to look at them.
#![allow(dead_code, reason = "each law uses a part of it")]

use kinetoscope::model::{Model, Target};
use kinetoscope::models::dem::Dem;
use kinetoscope::random::Seed;
use kinetoscope_manifest::model::{
    DemConfig, DiscRadius, Dissipation, GivenState, Placement, TimeStep,
};
use kinetoscope_manifest::quantity::{Finite, NonNegative, Positive, Share};
use kinetoscope_recording::channels::DemEnergy;
use kinetoscope_recording::frame::Frame;
use std::num::NonZeroU32;

pub(crate) const SEED: Seed = Seed { seed: 14, replicate: 0 };

/// A row of the state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    pub(crate) position: [f64; 2],
    /// At the positions' time.
    pub(crate) velocity: [f64; 2],
    /// The integrator's own.
    pub(crate) step_velocity: [f64; 2],
    pub(crate) radius: f64,
}

pub(crate) fn positive(value: f64) -> Positive {
    Positive::new(value).expect("above zero")
}

pub(crate) fn per_contact(steps: f64) -> TimeStep {
    TimeStep::PerContact(positive(steps))
}

pub(crate) fn restitution(value: f64) -> Dissipation {
    Dissipation::Restitution(Share::new(value).expect("in (0, 1]"))
}

pub(crate) fn damping(value: f64) -> Dissipation {
    Dissipation::Damping(NonNegative::new(value).expect("not negative"))
}

pub(crate) fn gravity(gx: f64, gy: f64) -> [Finite; 2] {
    finite([gx, gy])
}

pub(crate) fn equal(radius: f64) -> DiscRadius {
    DiscRadius::Equal(positive(radius))
}

fn finite(pair: [f64; 2]) -> [Finite; 2] {
    pair.map(|value| Finite::new(value).expect("finite"))
}

/// Sets the discs' number, positions and velocities.
pub(crate) fn given(config: DemConfig, discs: &[([f64; 2], [f64; 2])]) -> DemConfig {
    DemConfig {
        discs: NonZeroU32::new(discs.len() as u32).expect("not empty"),
        placement: Placement::Given(GivenState {
            positions: discs.iter().map(|disc| finite(disc.0)).collect(),
            velocities: discs.iter().map(|disc| finite(disc.1)).collect(),
        }),
        ..config
    }
}

/// The model at its start.
pub(crate) fn prepared(config: &DemConfig) -> Dem {
    Dem::prepare(config, SEED, false).unwrap_or_else(|refusal| panic!("{refusal}"))
}

/// Moves on to a step.
pub(crate) fn run_to(model: &mut Dem, step: u64) {
    if let Err(fault) = model.advance(Target::Count(step), u64::MAX) {
        panic!("{fault}");
    }
}

pub(crate) fn frame(model: &Dem) -> Frame {
    let mut frame = Frame::new();
    model.observe(&mut frame);
    frame
}

pub(crate) fn discs(model: &Dem) -> Vec<Disc> {
    frame(model)
        .state()
        .chunks_exact(9)
        .map(|row| Disc {
            position: [row[0], row[1]],
            velocity: [row[2], row[3]],
            step_velocity: [row[4], row[5]],
            radius: row[6],
        })
        .collect()
}

pub(crate) fn energy(model: &Dem) -> DemEnergy {
    frame(model).get().expect("every frame has its energy")
}

/// The length of one step, s.
pub(crate) fn time_step(model: &Dem) -> f64 {
    match model.extent() {
        kinetoscope::model::Extent::Steps { step, .. } => step,
        other => panic!("{other:?}"),
    }
}
