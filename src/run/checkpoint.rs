//! Checkpoints by the clock. A run resumes from its last checkpoint, and the recording shows no trace of it.

use crate::run::prepared::Prepared;
use crate::run::schedule::Schedule;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::restore;
use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::checkpoint::{self, decode_head};
use kinetoscope_recording::error::RecordError;
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::recorder::RecorderState;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Minimum time between two checkpoints, in units of a checkpoint's cost: checkpoints take at most 2 % of the run time.
const COST_RATIO: u32 = 50;
/// Expected speed of the first checkpoint: that of a slow machine and a slow disk.
const EXPECTED_BYTES_PER_S: u64 = 200_000_000;

/// A run in progress, at a frame or between two frames.
pub struct RunState<W: Write = RecordingFile> {
    /// The model, on its way to frame `next`.
    pub model: Box<dyn Model>,
    /// The targets of the frames.
    pub schedule: Schedule,
    /// The recorder, after frame `next - 1`.
    pub recorder: FrameWriter<W>,
    /// The next frame.
    pub next: u64,
}

impl<W: Write> RunState<W> {
    pub(crate) fn new(prepared: Prepared, recorder: FrameWriter<W>, next: u64) -> Self {
        let Prepared { model, schedule, .. } = prepared;
        Self { model, schedule, recorder, next }
    }
}

/// The content of a checkpoint.
pub(crate) struct Saved {
    pub(crate) next: u64,
    pub(crate) recorder: RecorderState,
    pub(crate) model: Box<dyn Model>,
}

impl Saved {
    /// Reads the last checkpoint of a run; `None` if there is none.
    pub(crate) fn read(
        folder: &Path,
        stem: &str,
        identity: &str,
        model: &ModelConfig,
    ) -> Result<Option<Self>, RecordError> {
        checkpoint::read(folder, stem, identity, |content| {
            let ((next, recorder), rest) = decode_head(content)?;
            Some(Self { next, recorder, model: restore(model, rest)? })
        })
    }
}

/// Saves one run to a file at intervals.
pub struct Checkpointer {
    folder: PathBuf,
    stem: String,
    identity: String,
    every: Duration,
    last: Instant,
    /// Cost of the last checkpoint; before the first one, its expected cost.
    cost: Option<Duration>,
}

impl Checkpointer {
    /// A policy with at least the time `every` between two checkpoints.
    #[must_use]
    pub fn new(folder: &Path, stem: &str, identity: String, every: Duration) -> Self {
        let (folder, stem) = (folder.to_owned(), stem.to_owned());
        Self { folder, stem, identity, every, last: Instant::now(), cost: None }
    }

    /// Time between two checkpoints of this cost. An interval of zero requests a checkpoint at every opportunity.
    fn pause(&self, cost: Duration) -> Duration {
        if self.every.is_zero() { Duration::ZERO } else { self.every.max(cost * COST_RATIO) }
    }
}

/// When and where a run in progress is saved.
pub trait CheckpointPolicy<W: Write> {
    /// Saves the run.
    ///
    /// # Errors
    /// A disk that fails.
    fn save(&mut self, state: &mut RunState<W>) -> Result<(), RecordError>;

    /// Saves the run if a checkpoint is due.
    ///
    /// # Errors
    /// A disk that fails.
    fn save_if_due(&mut self, state: &mut RunState<W>) -> Result<(), RecordError>;
}

/// The policy of a run that cannot be resumed.
pub struct NoCheckpoints;

impl<W: Write> CheckpointPolicy<W> for NoCheckpoints {
    fn save(&mut self, _: &mut RunState<W>) -> Result<(), RecordError> {
        Ok(())
    }

    fn save_if_due(&mut self, _: &mut RunState<W>) -> Result<(), RecordError> {
        Ok(())
    }
}

impl CheckpointPolicy<RecordingFile> for Checkpointer {
    fn save(&mut self, state: &mut RunState) -> Result<(), RecordError> {
        let started = Instant::now();
        let head = (state.next, state.recorder.save_point()?);
        checkpoint::write(&self.folder, &self.stem, &self.identity, &[&head, &*state.model])?;
        self.last = Instant::now();
        self.cost = Some(started.elapsed());
        Ok(())
    }

    fn save_if_due(&mut self, state: &mut RunState) -> Result<(), RecordError> {
        let waited = self.last.elapsed();
        if waited < self.every {
            return Ok(());
        }
        let cost = match self.cost {
            Some(cost) => cost,
            None => *self.cost.insert(expected_cost(checkpoint::size(&*state.model)?)),
        };
        if waited < self.pause(cost) { Ok(()) } else { self.save(state) }
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
