//! When a run is saved, and how it goes on: checkpoints by the clock, which leave no trace in the recording.

use kinetoscope_physics::model::Model;
use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::checkpoint;
use kinetoscope_recording::error::RecordError;
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::observer::FrameObserver;
use kinetoscope_recording::recorder::{Header, Recorder, RecorderState};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A run takes at least so many times a checkpoint's cost between two of them: at most 2 % of its time go to checkpoints.
const COST_RATIO: u32 = 50;
/// What a checkpoint is expected to cost before there was one: a slow machine encodes and a slow disk takes so many bytes a
/// second.
const FORESEEN_BYTES_PER_S: u64 = 200_000_000;

/// A run between two frames or in the middle of one.
pub struct RunState<M: Model, W: Write = RecordingFile> {
    /// The model, somewhere on its way to frame `next`.
    pub model: M,
    /// The recorder, after frame `next - 1`.
    pub recorder: FrameWriter<W>,
    /// The frame that comes next.
    pub next: u64,
}

#[derive(Serialize)]
struct Saved<'a, M> {
    next: u64,
    recorder: RecorderState,
    model: &'a M,
}

#[derive(Deserialize)]
struct Restored<M> {
    next: u64,
    recorder: RecorderState,
    model: M,
}

/// Saves one run now and then.
pub struct Checkpointer {
    folder: PathBuf,
    stem: String,
    identity: String,
    every: Duration,
    last: Instant,
    /// Of the last checkpoint; before there was one, as foreseen once the first could be due.
    cost: Option<Duration>,
}

impl Checkpointer {
    /// A checkpoint at least every so often, by the clock.
    #[must_use]
    pub fn new(folder: &Path, stem: &str, identity: String, every: Duration) -> Self {
        let (folder, stem) = (folder.to_owned(), stem.to_owned());
        Self { folder, stem, identity, every, last: Instant::now(), cost: None }
    }

    /// Time between two checkpoints of such a cost. An interval of zero asks for all that can be had, whatever it costs.
    fn pause(&self, cost: Duration) -> Duration {
        if self.every.is_zero() { Duration::ZERO } else { self.every.max(cost * COST_RATIO) }
    }
}

/// How a run under way is kept safe.
pub trait CheckpointPolicy<M: Model, W: Write> {
    /// Saves the run.
    ///
    /// # Errors
    /// A disk that fails.
    fn save(&mut self, state: &mut RunState<M, W>) -> Result<(), RecordError>;

    /// Saves the run if it is time.
    ///
    /// # Errors
    /// A disk that fails.
    fn save_if_due(&mut self, state: &mut RunState<M, W>) -> Result<(), RecordError>;
}

/// For a run that is not to be gone on with.
pub struct NoCheckpoints;

impl<M: Model, W: Write> CheckpointPolicy<M, W> for NoCheckpoints {
    fn save(&mut self, _: &mut RunState<M, W>) -> Result<(), RecordError> {
        Ok(())
    }

    fn save_if_due(&mut self, _: &mut RunState<M, W>) -> Result<(), RecordError> {
        Ok(())
    }
}

impl<M: Model> CheckpointPolicy<M, RecordingFile> for Checkpointer {
    fn save(&mut self, state: &mut RunState<M>) -> Result<(), RecordError> {
        let started = Instant::now();
        let recorder = state.recorder.save_point()?;
        let saved = Saved { next: state.next, recorder, model: &state.model };
        checkpoint::write(&self.folder, &self.stem, &self.identity, &saved)?;
        self.last = Instant::now();
        self.cost = Some(started.elapsed());
        Ok(())
    }

    fn save_if_due(&mut self, state: &mut RunState<M>) -> Result<(), RecordError> {
        let waited = self.last.elapsed();
        if waited < self.every {
            return Ok(());
        }
        let cost = match self.cost {
            Some(cost) => cost,
            None => *self.cost.insert(foreseen_cost(checkpoint::size(&state.model)?)),
        };
        if waited < self.pause(cost) { Ok(()) } else { self.save(state) }
    }
}

/// What a checkpoint of so many bytes is expected to cost.
fn foreseen_cost(bytes: u64) -> Duration {
    Duration::from_nanos(bytes.saturating_mul(1_000_000_000 / FORESEEN_BYTES_PER_S))
}

/// Goes on from the last checkpoint; `None` where there is none. `header` makes the recording's header from the model, and
/// `observer` watches what comes.
///
/// # Errors
/// A checkpoint or a partial file that can't be gone on with, or a disk that fails.
pub fn resume<M: Model>(
    folder: &Path,
    stem: &str,
    identity: &str,
    header: impl FnOnce(&M) -> Header,
    observer: impl FnOnce() -> Option<Box<dyn FrameObserver>>,
) -> Result<Option<RunState<M>>, RecordError> {
    let Some(restored) = checkpoint::read::<Restored<M>>(folder, stem, identity)? else {
        return Ok(None);
    };
    let Restored { next, recorder, model } = restored;
    let mut recorder = Recorder::resume(folder, stem, &header(&model), recorder)?;
    if let Some(observer) = observer() {
        recorder.show_to(observer)?;
    }
    Ok(Some(RunState { model, recorder: FrameWriter::start(recorder), next }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1e6 discs take some 93 MB: a first checkpoint after the shortest interval, 5 s, would cost a short run far more than 2 %.
    #[test]
    fn no_checkpoint_costs_more_than_two_per_cent_of_the_time_before_it() {
        let every = Duration::from_secs(5);
        let checkpointer = |every| Checkpointer::new(Path::new("."), "a run", String::new(), every);
        for bytes in [0, 1_000, 1_000_000, 93_000_000, 10_000_000_000] {
            let cost = foreseen_cost(bytes);
            let pause = checkpointer(every).pause(cost);
            assert!(pause >= every && cost.as_secs_f64() <= 0.02 * pause.as_secs_f64(), "{bytes}");
            assert_eq!(checkpointer(Duration::ZERO).pause(cost), Duration::ZERO);
        }
        assert_eq!(
            checkpointer(every).pause(foreseen_cost(93_000_000)),
            Duration::from_millis(23_250)
        );
    }
}
