//! `zoom`: recomputes an interval of a recorded run at a finer resolution.
//!
//! The run is executed twice from the nearest keyframe before the interval: first with the frames of the recording, whose
//! messages are compared, then with the fine frames, which are those of a run recorded at this resolution.

use crate::interrupt::Interrupt;
use crate::run::encoded;
use crate::run::prepared;
use crate::run::schedule::is_at_or_before;
use crate::verify::error::VerifyError;
use crate::verify::fine_frames::{FineFrames, Interval};
use crate::verify::keyframe_search::{Base, nearest};
use crate::verify::rerun::{Rerun, Stopped, advance};
use crate::verify::rerun_check::RerunCheck;
use crate::verify::restored_file::{Restored, check_output, written};
use crate::verify::source::{ReadablePart, Source};
use kinetoscope_console::Message;
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::reader::{Outcome, StoredFrames};
use kinetoscope_recording::recorder::Compression;
use std::io;
use std::num::NonZeroU64;
use std::path::Path;

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
) -> Result<Restored, VerifyError> {
    let source = Source::open(path)?;
    source.reject_other_physics()?;
    source.reject_part()?;
    let damage = ReadablePart::of(&source, interrupt)?.damage;
    let start = source.prepared_with_all_frames(interrupt)?;
    let fine = FineFrames::new(&start, &interval)?;
    let output = match output {
        Some(output) => output.to_owned(),
        None => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let Interval { from, to, .. } = interval;
            path.with_file_name(format!("{stem}.zoom_{from}_{to}.mcap"))
        }
    };
    check_output(&source, &output, &source.identity(&fine.manifest(&source)).1)?;
    let before = fine.target(fine.first.saturating_sub(1));
    let base = nearest(&source, &start, before, interrupt)?;
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
) -> Result<Passed, VerifyError> {
    let Base { prepared: mut start, first, mut notes } = base;
    let mut model = encoded(&*start.model)?;
    start.header.compression = Compression::None;
    let (frames, schedule) = (start.schedule.frames(), start.schedule.clone());
    let mut rerun = Rerun::new(start, interrupt);
    (rerun.first, rerun.is_part) = (first, true);
    let check = RerunCheck::start(&source.recording, &mut rerun)?;
    let (mut kept, stop) = (first.saturating_sub(1), rerun.stop.clone());
    rerun.record(io::sink(), &|_, _| {}, |state| {
        let last = state.next - 1;
        if last > kept && is_at_or_before(schedule.target(last), before) {
            (kept, model) = (last, encoded(&*state.model)?);
        }
        if last > 0 && (last == frames || is_at_or_before(end, schedule.target(last))) {
            stop.stop();
        }
        Ok(())
    })?;
    let findings = check.findings()?;
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
) -> Result<Outcome, VerifyError> {
    let mut start = fine.prepared(source, restored(source, model)?)?;
    start.header.stored = StoredFrames::From(fine.first);
    // By default, all frames of the part are drawn, which are few of the run.
    start.header.draw_every = source.manifest.record.draw_every.unwrap_or(NonZeroU64::MIN);
    if fine.first > 0 {
        advance_to(&mut *start.model, fine.target(fine.first - 1), interrupt)?;
    }
    let mut rerun = Rerun::new(start, interrupt);
    (rerun.first, rerun.last) = (fine.first, Some((fine.last, Outcome::Complete)));
    let recorded = rerun.record(file, &|_, _| {}, |_| Ok(()))?;
    recorded.sink.commit()?;
    Ok(recorded.outcome)
}

fn restored(source: &Source, model: &[u8]) -> Result<Box<dyn Model>, VerifyError> {
    prepared::restored(&source.manifest, model).ok_or_else(|| {
        VerifyError::Unsuitable(Message::new(
            "the state of the run cannot be restored",
            "this is a defect of the program: please report it",
        ))
    })
}

/// Advances to a target, unless the model is there.
fn advance_to(
    model: &mut dyn Model,
    target: Target,
    interrupt: &Interrupt,
) -> Result<(), VerifyError> {
    let is_there = match target {
        Target::Count(count) => model.count() == count,
        Target::Time(time) => model.time().to_bits() == time.to_bits(),
    };
    if is_there {
        return Ok(());
    }
    match advance(model, target, interrupt) {
        Ok(()) => Ok(()),
        Err(Stopped::Signal(code)) => Err(VerifyError::Interrupted(code)),
        Err(Stopped::Fault(fault)) => Err(VerifyError::Arguments(Message::new(
            format!("the run failed before the interval: {fault}"),
            "name an earlier interval",
        ))),
    }
}
