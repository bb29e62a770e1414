//! Checkpoints by the clock. A run resumes from its last checkpoint, and the recording shows no trace of it.

use crate::run::frame_loop::RunState;
use crate::run::resources::memory::{available_bytes, needed_memory_bytes};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::checkpoint;
use kinetoscope_recording::error::RecordError;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Minimum time between two checkpoints, in units of a checkpoint's cost: checkpoints take at most 2 % of the run time.
const COST_RATIO: u32 = 50;
/// Expected speed of the first checkpoint: that of a slow machine and a slow disk.
const EXPECTED_BYTES_PER_S: u64 = 200_000_000;

/// Size up to which any checkpoint is read.
const MIN_CHECKPOINT_LIMIT: u64 = 1 << 30;

/// Saves one run to a file at intervals.
pub(crate) struct Checkpointer {
    folder: PathBuf,
    stem: String,
    identity: String,
    every: Duration,
    last: Instant,
    /// Cost of the last checkpoint; before the first one, its expected cost.
    cost: Option<Duration>,
}

impl Checkpointer {
    /// Checkpoints with at least the time `every` between two of them.
    pub(crate) fn new(folder: &Path, stem: &str, identity: String, every: Duration) -> Self {
        let (folder, stem) = (folder.to_owned(), stem.to_owned());
        Self { folder, stem, identity, every, last: Instant::now(), cost: None }
    }

    /// Saves the run if a checkpoint is due, or in any case if `at_once`.
    ///
    /// # Errors
    /// A disk that fails.
    pub(crate) fn save(&mut self, state: &mut RunState, at_once: bool) -> Result<(), RecordError> {
        if !at_once && !self.is_due(state)? {
            return Ok(());
        }
        let started = Instant::now();
        let head = (state.next, state.recorder.save_point()?);
        checkpoint::write(&self.folder, &self.stem, &self.identity, &[&head, &*state.model])?;
        self.last = Instant::now();
        self.cost = Some(started.elapsed());
        Ok(())
    }

    fn is_due(&mut self, state: &RunState) -> Result<bool, RecordError> {
        let waited = self.last.elapsed();
        if waited < self.every {
            return Ok(false);
        }
        let cost = match self.cost {
            Some(cost) => cost,
            None => *self.cost.insert(expected_cost(checkpoint::size(&*state.model)?)),
        };
        Ok(waited >= self.pause(cost))
    }

    /// Time between two checkpoints of this cost. An interval of zero requests a checkpoint at every opportunity.
    fn pause(&self, cost: Duration) -> Duration {
        if self.every.is_zero() { Duration::ZERO } else { self.every.max(cost * COST_RATIO) }
    }
}

/// Maximum size of a checkpoint, which holds the model and one chunk of frames; of single collisions, no number is known.
pub(crate) fn max_checkpoint_bytes(manifest: &RunManifest) -> u64 {
    match manifest.particles_of_frames() {
        Some(_) => needed_memory_bytes(manifest).saturating_mul(2).max(MIN_CHECKPOINT_LIMIT),
        None => available_bytes(),
    }
}

/// Expected cost of a checkpoint of this size.
fn expected_cost(bytes: u64) -> Duration {
    Duration::from_nanos(bytes.saturating_mul(1_000_000_000 / EXPECTED_BYTES_PER_S))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The checkpoint of 1e6 discs has about 93 MB. If it were written after the minimum interval of 5 s, it would take far more
    /// than 2 % of a short run.
    #[test]
    fn checkpoints_take_at_most_two_percent_of_the_run_time() {
        let every = Duration::from_secs(5);
        let checkpointer = |every| Checkpointer::new(Path::new("."), "a run", String::new(), every);
        for bytes in [0, 1_000, 1_000_000, 93_000_000, 10_000_000_000] {
            let cost = expected_cost(bytes);
            let pause = checkpointer(every).pause(cost);
            assert!(pause >= every && cost.as_secs_f64() <= 0.02 * pause.as_secs_f64(), "{bytes}");
            assert_eq!(checkpointer(Duration::ZERO).pause(cost), Duration::ZERO);
        }
        assert_eq!(
            checkpointer(every).pause(expected_cost(93_000_000)),
            Duration::from_millis(23_250)
        );
    }
}
