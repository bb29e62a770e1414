//! One run on a disk: begin or resume it, save checkpoints, and leave a complete recording or one that can be resumed.

use crate::interrupt::Interrupt;
use crate::live::{GnuplotLoop, LiveServer};
use crate::run::checkpoint::{Checkpointer, max_checkpoint_bytes};
use crate::run::frame_loop::{RunError, RunSpec, RunState, record_frames, record_start};
use crate::run::prepared::{Prepared, restored};
use kinetoscope_console::{Explained, Message};
use kinetoscope_physics::{kind_of, state_columns_of};
use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::checkpoint::{self as checkpoint_file, decode_head};
use kinetoscope_recording::error::RecordError;
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::{Outcome, Recorder, RecorderState};
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The result of a run that left a readable recording.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// Complete, failed, or interrupted.
    pub outcome: Outcome,
    /// What failed, and what to change, if the physics failed.
    pub fault: Option<Message>,
    /// Whether the run resumed from a checkpoint.
    pub start: RunStart,
    /// Path of the recording.
    pub path: PathBuf,
    /// Number of recorded frames, including the start.
    pub frames: u64,
    /// Size of the recording.
    pub bytes: u64,
    /// Number of steps or events executed.
    pub work: u64,
    /// Elapsed time.
    pub wall_time: Duration,
}

/// How a run started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RunStart {
    /// No checkpoint existed.
    Fresh,
    /// A checkpoint existed but could not be used, for this reason.
    Restarted(String),
    /// The run resumed from a checkpoint.
    Resumed {
        /// The first frame that was recorded since.
        frame: u64,
    },
}

/// The circumstances of a run. They do not change a byte of the recording.
#[derive(Clone, Copy)]
pub struct RunContext<'a> {
    /// Whether to stop.
    pub interrupt: &'a Interrupt,
    /// Minimum time between two checkpoints.
    pub checkpoint_every: Duration,
    /// Receives the number of frames recorded after the start and their total number.
    pub on_frame: &'a (dyn Fn(u64, u64) + Sync),
    /// Called when the last byte is written and the model is dropped: what follows waits for the disk only.
    pub on_written: &'a (dyn Fn() + Sync),
    /// The server through which viewers observe one run at a time.
    pub live: Option<&'a LiveServer>,
    /// The folder in which gnuplot finds the newest frame of each run.
    pub gnuplot: Option<&'a GnuplotLoop>,
}

/// Executes a run or resumes it from its checkpoint. `start` is the run's start if the plan has kept it.
///
/// # Errors
/// A start that cannot be run, or a recording that could not be written. A physical failure and an interruption are reported
/// as outcomes.
pub fn execute(
    spec: &RunSpec<'_>,
    start: Option<Prepared>,
    context: RunContext<'_>,
) -> Result<RunReport, RunError> {
    let started = Instant::now();
    let RunSpec { manifest, folder, stem, run_key, .. } = spec;
    let kind = kind_of(&manifest.model);
    let identity = format!(
        "{run_key} program {} {} physics {}",
        env!("CARGO_PKG_VERSION"),
        kind.name,
        kind.physics_version
    );
    let (mut state, start) = begin(spec, start, &identity, context)?;
    if let Some(gnuplot) = context.gnuplot {
        let mut files =
            gnuplot.begin(stem, state_columns_of(&manifest.model), &state.model.scenery());
        let mut frame = Frame::new();
        state.model.observe(&mut frame);
        files.update(&frame, state.model.time());
        state.viewer = Some(Box::new(move |frame, time| files.update(frame, time)));
    }
    let every = context.checkpoint_every;
    let mut checkpointer = Checkpointer::new(folder, stem, identity, every);
    let save = |state: &mut RunState, at_once| checkpointer.save(state, at_once);
    let outcome = record_frames(&mut state, context.interrupt, context.on_frame, save)?;
    let RunState { model, recorder, fault, .. } = state;
    let (frames, work) = (recorder.frames_written(), model.count());
    let file = recorder.finish(&outcome)?;
    drop(model);
    (context.on_written)();
    let path = match outcome {
        Outcome::Interrupted => file.keep_partial()?,
        Outcome::Complete | Outcome::Fault(_) => {
            let path = file.final_path().to_owned();
            file.commit()?;
            checkpoint_file::remove(folder, stem)?;
            path
        }
    };
    Ok(RunReport {
        outcome,
        fault: fault.as_ref().map(Explained::message),
        start,
        bytes: fs::metadata(&path).map(|file| file.len()).unwrap_or_default(),
        path,
        frames,
        work,
        wall_time: started.elapsed(),
    })
}

/// Resumes a killed or interrupted run, or starts from scratch if there is no usable checkpoint.
fn begin(
    spec: &RunSpec<'_>,
    start: Option<Prepared>,
    identity: &str,
    context: RunContext<'_>,
) -> Result<(RunState, RunStart), RunError> {
    let RunSpec { manifest, canonical, run_key, folder, stem } = spec;
    let observer = || context.live.and_then(|live| live.observer(stem));
    let run_start = match resume(spec, identity) {
        Ok(Some((mut recorder, next, prepared))) => {
            if let Some(observer) = observer() {
                recorder.show_to(observer)?;
            }
            let state = RunState::new(prepared, FrameWriter::start(recorder), next);
            return Ok((state, RunStart::Resumed { frame: next }));
        }
        Ok(None) => RunStart::Fresh,
        Err(error @ RecordError::Locked { .. }) => return Err(error.into()),
        Err(error) => RunStart::Restarted(error.to_string()),
    };
    let start = match start {
        Some(start) => start,
        None => Prepared::new(manifest, canonical, run_key, context.interrupt)?,
    };
    let file = RecordingFile::create(folder, stem)?;
    // An older checkpoint would refer to bytes that no longer exist.
    checkpoint_file::remove(folder, stem)?;
    let mut recorder = Recorder::create_resumable(file, &start.header)?;
    if let Some(observer) = observer() {
        recorder.show_to(observer)?;
    }
    Ok((record_start(start, recorder)?, run_start))
}

/// Restores the run from its last checkpoint; `None` if there is none.
fn resume(
    spec: &RunSpec<'_>,
    identity: &str,
) -> Result<Option<(Recorder<RecordingFile>, u64, Prepared)>, RecordError> {
    let RunSpec { manifest, canonical, run_key, folder, stem } = spec;
    let max_bytes = max_checkpoint_bytes(manifest);
    let saved = checkpoint_file::read(folder, stem, identity, max_bytes, |content| {
        let (head, rest): ((u64, RecorderState), _) = decode_head(content)?;
        Some((head, restored(manifest, rest)?))
    })?;
    let Some(((next, recorder), model)) = saved else { return Ok(None) };
    let prepared = Prepared::of(model, manifest, canonical, run_key)
        .map_err(|error| RecordError::Container(error.to_string()))?;
    if recorder.frames() != next || !prepared.is_before_frame(next) {
        let path = checkpoint_file::path(folder, stem);
        let what = "its state belongs to another frame".to_owned();
        return Err(RecordError::NotContinued { path, what });
    }
    let recorder = Recorder::resume(folder, stem, &prepared.header, recorder)?;
    Ok(Some((recorder, next, prepared)))
}
