//! When a run is saved, and how it goes on: checkpoints by the clock, which leave no trace in the recording.

use crate::model::Model;
use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::checkpoint;
use kinetoscope_recording::error::RecordError;
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::recorder::{Header, Recorder, RecorderState};
use kinetoscope_recording::spectator::Spectator;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A run takes at least so many times a checkpoint's cost between two of them: at most 2 % of its time go to checkpoints.
const COST_RATIO: u32 = 50;

/// A run between two frames or in the middle of one.
pub struct Underway<M, W: Write = RecordingFile> {
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
    cost: Duration,
}

impl Checkpointer {
    /// A checkpoint at least every so often, by the clock.
    #[must_use]
    pub fn new(folder: &Path, stem: &str, identity: String, every: Duration) -> Self {
        let (folder, stem) = (folder.to_owned(), stem.to_owned());
        let (last, cost) = (Instant::now(), Duration::ZERO);
        Self { folder, stem, identity, every, last, cost }
    }
}

/// How a run under way is kept safe.
pub trait Safekeeping<M, W: Write> {
    /// Saves the run.
    ///
    /// # Errors
    /// A disk that fails.
    fn save(&mut self, underway: &mut Underway<M, W>) -> Result<(), RecordError>;

    /// Saves the run if it is time.
    ///
    /// # Errors
    /// A disk that fails.
    fn save_if_due(&mut self, underway: &mut Underway<M, W>) -> Result<(), RecordError>;
}

/// For a run that is not to be gone on with.
pub struct NeverSaved;

impl<M, W: Write> Safekeeping<M, W> for NeverSaved {
    fn save(&mut self, _: &mut Underway<M, W>) -> Result<(), RecordError> {
        Ok(())
    }

    fn save_if_due(&mut self, _: &mut Underway<M, W>) -> Result<(), RecordError> {
        Ok(())
    }
}

impl<M: Model> Safekeeping<M, RecordingFile> for Checkpointer {
    fn save(&mut self, underway: &mut Underway<M>) -> Result<(), RecordError> {
        let started = Instant::now();
        let recorder = underway.recorder.save_point()?;
        let saved = Saved { next: underway.next, recorder, model: &underway.model };
        checkpoint::write(&self.folder, &self.stem, &self.identity, &saved)?;
        self.last = Instant::now();
        self.cost = started.elapsed();
        Ok(())
    }

    fn save_if_due(&mut self, underway: &mut Underway<M>) -> Result<(), RecordError> {
        let affordable = self.cost * COST_RATIO;
        // Zero asks for all that can be had, whatever it costs.
        let pause = if self.every.is_zero() { self.every } else { self.every.max(affordable) };
        if self.last.elapsed() < pause { Ok(()) } else { self.save(underway) }
    }
}

/// Goes on from the last checkpoint; `None` where there is none. `header` makes the recording's header from the model, and
/// `spectator` watches what comes.
///
/// # Errors
/// A checkpoint or a partial file that can't be gone on with, or a disk that fails.
pub fn go_on<M: Model>(
    folder: &Path,
    stem: &str,
    identity: &str,
    header: impl FnOnce(&M) -> Header,
    spectator: impl FnOnce() -> Option<Box<dyn Spectator>>,
) -> Result<Option<Underway<M>>, RecordError> {
    let Some(restored) = checkpoint::read::<Restored<M>>(folder, stem, identity)? else {
        return Ok(None);
    };
    let Restored { next, recorder, model } = restored;
    let mut recorder = Recorder::resume(folder, stem, &header(&model), recorder)?;
    if let Some(spectator) = spectator() {
        recorder.show_to(spectator)?;
    }
    Ok(Some(Underway { model, recorder: FrameWriter::start(recorder), next }))
}
