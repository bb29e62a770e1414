//! The loop of one run: advance the model from frame to frame, record, and end in order on an interruption or a failure.

use crate::interrupt::Interrupt;
use crate::run::prepared::Prepared;
use crate::run::schedule::Schedule;
use kinetoscope_console::Explained;
use kinetoscope_manifest::RunManifest;
use kinetoscope_physics::model::{Model, Progress, SetupError, SimulationFault};
use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::error::{ReadError, RecordError};
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::frame::{Frame, Level, LogLine};
use kinetoscope_recording::recorder::{Clock, Outcome, Recorder, StoredFrames};
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};
use thiserror::Error;

/// The run to execute and the location of its recording.
#[derive(Clone, Debug)]
pub struct RunSpec<'a> {
    /// Model, seed, replicate and what to record.
    pub manifest: &'a RunManifest,
    /// The canonical text of `manifest`, embedded in the recording.
    pub canonical: String,
    /// The run key.
    pub run_key: &'a str,
    /// The folder of the recording.
    pub folder: &'a Path,
    /// The recording's file name without its extension.
    pub stem: String,
}

/// Receives each frame and its time, for a viewer.
pub(crate) type FrameViewer = Box<dyn FnMut(&Frame, f64)>;

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
    /// Shown each frame.
    pub(crate) viewer: Option<FrameViewer>,
    /// The failure that ended the run.
    pub(crate) fault: Option<SimulationFault>,
    /// The frames of which the state of the model is encoded: those of [`StoredFrames::Keyframes`], and the number of all frames.
    stored: (StoredFrames, Option<u64>),
}

impl<W: Write> RunState<W> {
    pub(crate) fn new(prepared: Prepared, recorder: FrameWriter<W>, next: u64) -> Self {
        let Prepared { model, schedule, header } = prepared;
        let stored = (header.stored, header.frames_expected);
        Self { model, schedule, recorder, next, viewer: None, fault: None, stored }
    }

    /// Encodes the state of the model at the keyframes of another recording of this run, for an observer.
    pub(crate) fn with_keyframes_of(mut self, stored: StoredFrames) -> Self {
        self.stored.0 = stored;
        self
    }

    /// Shows each frame from now on, and its time.
    #[must_use]
    pub fn with_viewer(mut self, viewer: FrameViewer) -> Self {
        self.viewer = Some(viewer);
        self
    }

    /// The encoded state of the model, if the next frame to write is a keyframe.
    ///
    /// # Errors
    /// A state that cannot be encoded: a defect of the program.
    fn keyframe(&self) -> Result<Option<Vec<u8>>, RecordError> {
        let (stored, frames) = self.stored;
        let is_keyframe = matches!(stored, StoredFrames::Keyframes(_))
            && stored.has(self.recorder.frames_written(), frames);
        is_keyframe.then(|| encoded(&*self.model)).transpose()
    }
}

impl<W: Write + Send + 'static> RunState<W> {
    /// Advances by at most so many steps or events, and records the frame that is reached. This needs no clock.
    ///
    /// # Errors
    /// A sink that fails. A physical failure is an outcome.
    pub fn advance(&mut self, budget: u64) -> Result<Advanced, RecordError> {
        if self.next > self.schedule.frames() {
            return Ok(Advanced::ToEnd(Outcome::Complete));
        }
        let progress = self.model.advance(self.schedule.target(self.next), budget);
        self.record_progress(progress)
    }

    fn record_progress(
        &mut self,
        progress: Result<Progress, SimulationFault>,
    ) -> Result<Advanced, RecordError> {
        match progress {
            Ok(Progress::Working) => Ok(Advanced::Working),
            Ok(Progress::Reached) => {
                record_now(self)?;
                self.next += 1;
                Ok(Advanced::ToFrame)
            }
            Err(fault) => {
                let recorded = fault.recorded().to_owned();
                self.recorder.remark(LogLine { level: Level::Error, text: recorded.clone() })?;
                self.fault = Some(fault);
                Ok(Advanced::ToEnd(Outcome::Fault(recorded)))
            }
        }
    }
}

/// How far a part of the work has brought a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Advanced {
    /// On its way to the next frame.
    Working,
    /// To a frame, which is recorded.
    ToFrame,
    /// To its end.
    ToEnd(Outcome),
}

/// The encoded state of a model.
///
/// # Errors
/// A state that cannot be encoded: a defect of the program.
pub(crate) fn encoded(model: &dyn Model) -> Result<Vec<u8>, RecordError> {
    let mut bytes = Vec::new();
    let encoded = model.encode_into(&mut bytes);
    encoded.map_err(|error| RecordError::Container(format!("a keyframe: {error}")))?;
    Ok(bytes)
}

/// The reason why a run left no usable recording.
#[derive(Debug, Error)]
pub enum RunError {
    /// The start cannot be built or cannot be run.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The recording could not be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The recording in memory could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
}

impl Explained for RunError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Setup(error) => error.help(),
            Self::Record(error) => error.help(),
            Self::Read(error) => error.help(),
        }
    }
}

/// Records the first frame of a run.
///
/// # Errors
/// A sink that fails.
pub fn record_start<W: Write + Send + 'static>(
    start: Prepared,
    recorder: Recorder<W>,
) -> Result<RunState<W>, RecordError> {
    record_start_with(start, FrameWriter::start(recorder))
}

/// As [`record_start`], with a recorder that stays on this thread: each frame is written when it is reached.
///
/// # Errors
/// A sink that fails.
pub fn record_start_on_this_thread<W: Write + Send + 'static>(
    start: Prepared,
    recorder: Recorder<W>,
) -> Result<RunState<W>, RecordError> {
    record_start_with(start, FrameWriter::on_this_thread(recorder))
}

fn record_start_with<W: Write + Send + 'static>(
    start: Prepared,
    writer: FrameWriter<W>,
) -> Result<RunState<W>, RecordError> {
    let mut state = RunState::new(start, writer, 1);
    record_now(&mut state)?;
    Ok(state)
}

/// Records the frame at which the model is.
///
/// # Errors
/// A sink that fails.
pub(crate) fn record_now<W: Write + Send + 'static>(
    state: &mut RunState<W>,
) -> Result<(), RecordError> {
    let keyframe = state.keyframe()?;
    let RunState { model, viewer, .. } = state;
    let clock = Clock { count: model.count(), time: model.time() };
    state.recorder.write(clock, |frame| {
        model.observe(frame);
        if let Some(keyframe) = keyframe {
            *frame.model_mut() = keyframe;
        }
        if let Some(show) = viewer {
            show(frame, clock.time);
        }
    })
}

/// Advances the run and records its remaining frames. `save` is called between two parts of the work, with `true` if the run
/// stops there and must be saved.
///
/// # Errors
/// A sink or a disk that fails. A physical failure and an interruption are outcomes.
pub fn record_frames<W: Write + Send + 'static>(
    state: &mut RunState<W>,
    interrupt: &Interrupt,
    on_frame: &(dyn Fn(u64, u64) + Sync),
    mut save: impl FnMut(&mut RunState<W>, bool) -> Result<(), RecordError>,
) -> Result<Outcome, RecordError> {
    let mut budget = 1;
    let frames = state.schedule.frames();
    while state.next <= frames {
        if interrupt.is_raised() {
            save(state, true)?;
            return Ok(Outcome::Interrupted);
        }
        let started = Instant::now();
        let progress = state.model.advance(state.schedule.target(state.next), budget);
        budget = adapted_budget(budget, started.elapsed());
        match state.record_progress(progress)? {
            Advanced::Working => {}
            Advanced::ToFrame => on_frame(state.next - 1, frames),
            Advanced::ToEnd(outcome) => return Ok(outcome),
        }
        save(state, false)?;
    }
    Ok(Outcome::Complete)
}

/// Number of steps or events for the next call of `Model::advance`, from the time that the last call took: large enough for
/// speed, small enough for a quick reaction to a signal. The division of the work does not change a bit of the trajectory;
/// therefore, it may depend on the clock.
pub(crate) fn adapted_budget(steps: u64, took: Duration) -> u64 {
    const SHORT: Duration = Duration::from_millis(20);
    const LONG: Duration = Duration::from_millis(100);
    if took < SHORT {
        steps.saturating_mul(2)
    } else if took > LONG {
        (steps / 2).max(1)
    } else {
        steps
    }
}
