//! How long a task will take at most, so that a cluster can place it: from the plan, with figures of a slow processor.
//!
//! A wrong figure loses nothing: what a time limit cuts goes on from its checkpoint in the next task.

use crate::plan::PlannedRun;
use kinetoscope_manifest::model::{ModelConfig, RunLength};

/// No task is given less, minutes: starts and shared file systems have their own pace.
const LEAST_MIN: u64 = 15;
/// Limits over what is expected.
const MARGIN: f64 = 3.0;

/// Work that a slow processor does in a second, a tenth of what one core of a server of 2024 does: steps times particles,
/// or events. `None` of models whose plan does not count their work.
fn work_per_second(model: &ModelConfig) -> Option<f64> {
    match model {
        ModelConfig::Dem(_) => Some(1e6),
        ModelConfig::Gas(config) => config.propagation.time_step_s().map(|_| 1e7),
        ModelConfig::Packing(config) => match config.length {
            RunLength::EventsPerDisc(_) => Some(2e5),
            RunLength::Duration(_) => None,
        },
        ModelConfig::Orbit(_) => Some(1e6),
    }
}

/// Minutes that a task of these runs may take; `None` where the plan does not tell.
#[must_use]
pub fn time_limit_min(runs: &[&PlannedRun]) -> Option<u64> {
    let mut seconds = 0.0;
    for run in runs {
        let work = run.estimate()?.relative_cost;
        seconds += work / work_per_second(&run.run.manifest.model)?;
    }
    let minutes = (MARGIN * seconds / 60.0).ceil() as u64;
    Some(minutes.max(LEAST_MIN))
}
