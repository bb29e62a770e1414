//! The time limit of a task, estimated from the plan for a slow processor.
//!
//! A wrong estimate loses no work: a run that reaches the limit resumes from its checkpoint in the next task.

use crate::plan::PlannedRun;
use kinetoscope_manifest::model::{ModelConfig, RunLength};

/// Minimum limit in minutes, for the start of a task and slow file systems.
const MIN_LIMIT_MIN: u64 = 15;
/// Ratio of the limit to the expected time.
const MARGIN: f64 = 3.0;

/// Work per second of a slow processor, 1/10 of one core of a server of 2024: steps times particles, or events. `None` for
/// models whose work is not known from the plan.
fn work_per_second(model: &ModelConfig) -> Option<f64> {
    match model {
        ModelConfig::Gas(config) => config.propagation.time_step_s().map(|_| 1e7),
        ModelConfig::Packing(config) => match config.length {
            RunLength::EventsPerDisc(_) => Some(2e5),
            RunLength::Duration(_) => None,
        },
        _ => Some(1e6),
    }
}

/// Time limit of a task in minutes; `None` if it cannot be estimated.
#[must_use]
pub fn time_limit_min(runs: &[&PlannedRun]) -> Option<u64> {
    let mut seconds = 0.0;
    for run in runs {
        let work = run.estimate()?.relative_cost;
        seconds += work / work_per_second(&run.run.manifest.model)?;
    }
    let minutes = (MARGIN * seconds / 60.0).ceil() as u64;
    Some(minutes.max(MIN_LIMIT_MIN))
}
