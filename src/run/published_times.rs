//! The published times of the packing exercise, which `benchmark` compares with its own.

use kinetoscope_manifest::model::{Boundary, InitialVelocities, ModelConfig, RunLength};

/// Discs, mean seconds with velocities of unit variance, and with variance 1/n: the two tables of the packing exercise, means of 100
/// runs of 100 n events.
const PACKING_EXERCISE: [(u32, f64, f64); 10] = [
    (5, 0.0048, 0.0046),
    (10, 0.1533, 0.1501),
    (15, 0.3339, 0.3303),
    (20, 0.5741, 0.5963),
    (25, 0.8932, 0.9018),
    (30, 1.2810, 1.3283),
    (35, 1.7864, 1.7646),
    (40, 2.3360, 2.4005),
    (45, 3.6516, 3.0393),
    (50, 12.8829, 3.7069),
];
/// Events per disc of those runs.
const EVENTS_PER_DISC: u32 = 100;

/// The published mean time of runs with as many discs and events and the same distribution of velocities, s.
pub(super) fn published_s(model: &ModelConfig) -> Option<f64> {
    let ModelConfig::Packing(config) = model else { return None };
    let is_same_work = matches!(config.length, RunLength::EventsPerDisc(events) if events.get() == EVENTS_PER_DISC);
    if !is_same_work || config.boundary != Boundary::Walls {
        return None;
    }
    let mut rows = PACKING_EXERCISE.iter();
    let &(_, unit_variance, variance_one_over_n) =
        rows.find(|(discs, ..)| *discs == config.discs.get())?;
    Some(match config.initial_velocities {
        InitialVelocities::UnitVariance => unit_variance,
        InitialVelocities::VarianceOneOverN => variance_one_over_n,
    })
}
