//! `fill`: restores all frames of a recording that keeps only keyframes.

use crate::interrupt::Interrupt;
use crate::run::prepared::Prepared;
use crate::run::{record_frames, record_start};
use crate::verify::check_thread::CheckThread;
use crate::verify::rerun_check::RerunCheck;
use crate::verify::restore::{RestoreError, Restored, Source, written};
use kinetoscope_console::text::shown_path;
use kinetoscope_manifest::RunKey;
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::reader::{Outcome, StoredFrames};
use kinetoscope_recording::recorder::Recorder;
use std::path::{Path, PathBuf};

/// Executes the run of a recording again and records all its frames, in the bytes that the run gives with `keep = "all"`. Each
/// message is compared with the keyframes and hashes of the recording, which is not changed.
///
/// # Errors
/// A recording that is not finished, has all frames or is damaged, a rerun that differs, or an interruption. No file is left.
pub fn fill(
    path: &Path,
    output: Option<&Path>,
    interrupt: &Interrupt,
    on_frame: &(dyn Fn(u64, u64) + Sync),
) -> Result<Restored, RestoreError> {
    let source = Source::open(path)?;
    check_suitable(&source, interrupt)?;
    let start = source.start()?;
    let output = match output {
        Some(output) => output.to_owned(),
        None => default_output(&source, &start.header.run_key),
    };
    source.check_output(&output, &start.header.run_key)?;
    let (frames, equal_frames) =
        written(&output, |file| record(&source, start, file, interrupt, on_frame))?;
    Ok(Restored { path: output, frames, equal_frames, notes: Vec::new(), damage: None })
}

/// Executes the run and records it; returns the number of frames, and of those that were compared.
fn record(
    source: &Source,
    start: Prepared,
    file: RecordingFile,
    interrupt: &Interrupt,
    on_frame: &(dyn Fn(u64, u64) + Sync),
) -> Result<(u64, u64), RestoreError> {
    let stop = interrupt.with_own_stop();
    let mut recorder = Recorder::create(file, &start.header)?;
    let (check, findings) = RerunCheck::new(&source.recording, 0, None, &stop)?;
    recorder.show_to(Box::new(CheckThread::new(check)))?;
    let mut state = record_start(start, recorder)?;
    let outcome = record_frames(&mut state, &stop, on_frame, |_, _| Ok(()))?;
    let frames = state.recorder.frames_written();
    let file = state.recorder.finish(&outcome)?;
    let mut findings = findings.take();
    complete(source, &outcome, interrupt, |source| {
        source.differences(&mut findings)?;
        match findings.unreadable.take() {
            Some(error) => Err(error.into()),
            None if findings.equal_frames == frames => Ok(()),
            None => Err(RestoreError::Unsuitable(format!(
                "only {} of {frames} frames were compared: report this",
                findings.equal_frames
            ))),
        }
    })?;
    file.commit()?;
    Ok((frames, findings.equal_frames))
}

/// Whether the result is complete and equal.
fn complete(
    source: &Source,
    outcome: &Outcome,
    interrupt: &Interrupt,
    check: impl FnOnce(&Source) -> Result<(), RestoreError>,
) -> Result<(), RestoreError> {
    if let Some(code) = interrupt.exit_code() {
        return Err(RestoreError::Interrupted(code));
    }
    check(source)?;
    if source.recording.provenance().outcome.as_ref() == Some(outcome) {
        return Ok(());
    }
    let what = format!(
        "{}: the rerun ends in another way\nhelp: compare versions with `kinetoscope info`",
        shown_path(source.path())
    );
    Err(RestoreError::Unsuitable(what))
}

fn check_suitable(source: &Source, interrupt: &Interrupt) -> Result<(), RestoreError> {
    // What the rerun does not read may be damaged as well, such as the summary at the end.
    if let Some(damage) = source.damage(interrupt)? {
        return Err(damage.into());
    }
    let provenance = source.recording.provenance();
    let path = shown_path(source.path());
    match provenance.stored {
        StoredFrames::Keyframes(_) => {}
        StoredFrames::All => {
            let what = format!("{path} has all frames\nhelp: there is nothing to fill");
            return Err(RestoreError::Arguments(what));
        }
        StoredFrames::From(_) => {
            let what =
                format!("{path} is a part of a run\nhelp: name the recording of the whole run");
            return Err(RestoreError::Arguments(what));
        }
    }
    match provenance.outcome {
        Some(Outcome::Complete | Outcome::Fault(_)) => Ok(()),
        Some(Outcome::Interrupted) | None => Err(RestoreError::Unsuitable(format!(
            "{path} is not finished or damaged at its end\nhelp: run its manifest again to finish it"
        ))),
    }
}

/// The name that the recording of all frames has: the run key at the end of the name is replaced.
fn default_output(source: &Source, key: &str) -> PathBuf {
    let own = &source.recording.provenance().run_key;
    let stem = source.path().file_stem().unwrap_or_default().to_string_lossy();
    let renamed = RunKey::from_hex(key).and_then(|key| key.in_place_of(own, &stem));
    let stem = renamed.unwrap_or_else(|| format!("{stem}.full"));
    source.path().with_file_name(format!("{stem}.mcap"))
}
