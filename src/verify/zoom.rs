//! `zoom`: recomputes an interval of a recorded run at a finer resolution.
//!
//! The run is executed twice from the nearest keyframe before the interval: first with the frames of the recording, whose
//! messages are compared, then with the fine frames, which are those of a run recorded at this resolution.

use crate::interrupt::Interrupt;
use crate::run::schedule::is_at_or_before;
use crate::run::{RunState, encoded, record_frames, record_start};
use crate::verify::check_thread::CheckThread;
use crate::verify::fine_frames::{FineFrames, Interval};
use crate::verify::keyframe_search::{Base, nearest};
use crate::verify::rerun_check::RerunCheck;
use crate::verify::restore::{RestoreError, Restored, Source, written};
use kinetoscope_console::text::shown_path;
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_physics::restore;
use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::channels::TRAIL;
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::reader::{Outcome, StoredFrames};
use kinetoscope_recording::recorder::{Compression, Recorder};
use std::io;
use std::path::Path;

/// Steps of one call, after which an interrupt is noticed.
const BUDGET: u64 = 10_000;

/// Recomputes an interval and records it to `output`, by default a file next to the recording.
///
/// # Errors
/// An interval outside the run or finer than its steps, a recording of another physics version, a rerun that differs from the
/// recording, or an interruption. No file is left.
pub fn zoom(
    path: &Path,
    interval: Interval,
    output: Option<&Path>,
    interrupt: &Interrupt,
) -> Result<Restored, RestoreError> {
    let source = Source::open(path)?;
    if let StoredFrames::From(_) = source.recording.provenance().stored {
        let what = format!(
            "{} is a part of a run\nhelp: name the recording of the whole run",
            shown_path(path)
        );
        return Err(RestoreError::Arguments(what));
    }
    let damage = source.damage(interrupt)?;
    let start = source.start()?;
    let fine = FineFrames::new(&start, &interval)?;
    let output = match output {
        Some(output) => output.to_owned(),
        None => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let Interval { from, to, .. } = interval;
            path.with_file_name(format!("{stem}.zoom_{from}_{to}.mcap"))
        }
    };
    source.check_output(&output, &source.identity(&fine.manifest(&source)).1)?;
    let before = fine.target(fine.first.saturating_sub(1));
    let base = nearest(&source, &start, before)?;
    let passed = check(&source, base, before, fine.target(fine.last), interrupt)?;
    let outcome = written(&output, |file| record(&source, &passed.model, &fine, file, interrupt))?;
    let mut notes = passed.notes;
    if let Outcome::Fault(fault) = outcome {
        notes.push(format!("the run failed in this interval: {fault}"));
    }
    let frames = fine.last - fine.first + 1;
    Ok(Restored { path: output, frames, equal_frames: passed.equal_frames, notes, damage })
}

/// The run up to the interval, and what was compared.
struct Passed {
    /// The state of the model at the last recorded frame before the interval.
    model: Vec<u8>,
    equal_frames: u64,
    notes: Vec<String>,
}

/// Executes the run from a base past the interval, and compares the recorded frames.
fn check(
    source: &Source,
    base: Base,
    before: Target,
    end: Target,
    interrupt: &Interrupt,
) -> Result<Passed, RestoreError> {
    let Base { prepared: mut start, frame: base, mut notes } = base;
    let mut model = encoded(&*start.model)?;
    start.header.compression = Compression::None;
    let stop = interrupt.with_own_stop();
    let mut recorder = Recorder::create(io::sink(), &start.header)?;
    // The paths so far begin before the first frame of the rerun.
    let left_out = Some(TRAIL);
    let (check, findings) = RerunCheck::new(&source.recording, base + 1, left_out, &stop)?;
    recorder.show_to(Box::new(CheckThread::new(check)))?;
    let recorder = recorder.at_frame(base + 1);
    let (frames, schedule) = (start.schedule.frames(), start.schedule.clone());
    let mut state = RunState::new(start, FrameWriter::start(recorder), base + 1);
    let mut kept = base;
    let outcome = record_frames(&mut state, &stop, &|_, _| {}, |state, _| {
        let last = state.next - 1;
        if last > kept && is_at_or_before(schedule.target(last), before) {
            (kept, model) = (last, encoded(&*state.model)?);
        }
        if last > 0 && (last == frames || is_at_or_before(end, schedule.target(last))) {
            stop.stop();
        }
        Ok(())
    })?;
    state.recorder.finish(&outcome)?;
    if let Some(code) = interrupt.exit_code() {
        return Err(RestoreError::Interrupted(code));
    }
    let mut findings = findings.take();
    source.differences(&mut findings)?;
    if findings.unreadable.is_some() {
        notes.push("frames after the damage were not compared".to_owned());
    }
    Ok(Passed { model, equal_frames: findings.equal_frames, notes })
}

/// Records the fine frames.
fn record(
    source: &Source,
    model: &[u8],
    fine: &FineFrames,
    file: RecordingFile,
    interrupt: &Interrupt,
) -> Result<Outcome, RestoreError> {
    let stop = interrupt.with_own_stop();
    let mut start = fine.prepared(source, restored(source, model)?)?;
    start.header.stored = StoredFrames::From(fine.first);
    let recorder = Recorder::create(file, &start.header)?;
    let mut state = if fine.first == 0 {
        record_start(start, recorder)?
    } else {
        advance(&mut *start.model, fine.target(fine.first - 1), interrupt)?;
        RunState::new(start, FrameWriter::start(recorder), fine.first)
    };
    if fine.last == 0 {
        stop.stop();
    }
    let on_frame = |done, _| {
        if done == fine.last {
            stop.stop();
        }
    };
    let mut outcome = record_frames(&mut state, &stop, &on_frame, |_, _| Ok(()))?;
    if outcome == Outcome::Interrupted && interrupt.exit_code().is_none() {
        outcome = Outcome::Complete;
    }
    let file = state.recorder.finish(&outcome)?;
    if let Some(code) = interrupt.exit_code() {
        return Err(RestoreError::Interrupted(code));
    }
    file.commit()?;
    Ok(outcome)
}

fn restored(source: &Source, model: &[u8]) -> Result<Box<dyn Model>, RestoreError> {
    restore(&source.manifest.model, model).ok_or_else(|| {
        RestoreError::Unsuitable("the state of the run cannot be restored: report this".to_owned())
    })
}

/// Advances to a target, unless the model is there.
fn advance(
    model: &mut dyn Model,
    target: Target,
    interrupt: &Interrupt,
) -> Result<(), RestoreError> {
    let is_there = match target {
        Target::Count(count) => model.count() == count,
        Target::Time(time) => model.time().to_bits() == time.to_bits(),
    };
    if is_there {
        return Ok(());
    }
    loop {
        match model.advance(target, BUDGET) {
            Ok(Progress::Reached) => return Ok(()),
            Ok(Progress::Working) => {}
            Err(fault) => {
                let what = format!(
                    "the run failed before the interval: {}\nhelp: name an earlier interval",
                    fault.0
                );
                return Err(RestoreError::Arguments(what));
            }
        }
        if let Some(code) = interrupt.exit_code() {
            return Err(RestoreError::Interrupted(code));
        }
    }
}
