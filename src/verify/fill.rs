//! `fill`: restores all frames of a recording that keeps only keyframes.

use crate::interrupt::Interrupt;
use crate::run::prepared::Prepared;
use crate::verify::error::VerifyError;
use crate::verify::rerun::Rerun;
use crate::verify::rerun_check::RerunCheck;
use crate::verify::restored_file::{Restored, check_output, written};
use crate::verify::source::{ReadablePart, Source};
use kinetoscope_console::Message;
use kinetoscope_console::text::shown_path;
use kinetoscope_manifest::RunKey;
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::reader::{Outcome, StoredFrames};
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
) -> Result<Restored, VerifyError> {
    let source = Source::open(path)?;
    source.reject_other_physics()?;
    check_suitable(&source, interrupt)?;
    let start = source.prepared_with_all_frames(interrupt)?;
    let output = match output {
        Some(output) => output.to_owned(),
        None => default_output(&source, &start.header.run_key),
    };
    check_output(&source, &output, &start.header.run_key)?;
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
) -> Result<(u64, u64), VerifyError> {
    let mut rerun = Rerun::new(start, interrupt);
    let check = RerunCheck::start(&source.recording, &mut rerun)?;
    let recorded = rerun.record(file, on_frame, |_| Ok(()))?;
    let (frames, findings) = (recorded.frames, check.findings()?);
    if let Some(error) = findings.unreadable {
        return Err(error.into());
    }
    let path = shown_path(source.recording.path());
    if findings.equal_frames != frames {
        let compared = findings.equal_frames;
        return Err(VerifyError::Unsuitable(Message::new(
            format!("only {compared} of {frames} frames were compared"),
            "this is a defect of the program: please report it",
        )));
    }
    if source.recording.provenance().outcome.as_ref() != Some(&recorded.outcome) {
        return Err(VerifyError::Unsuitable(Message::new(
            format!("{path}: the rerun ends in another way"),
            "compare versions with `kinetoscope info`",
        )));
    }
    recorded.sink.commit()?;
    Ok((frames, findings.equal_frames))
}

fn check_suitable(source: &Source, interrupt: &Interrupt) -> Result<(), VerifyError> {
    // What the rerun does not read may be damaged as well, such as the summary at the end.
    if let Some(damage) = ReadablePart::of(source, interrupt)?.damage {
        return Err(damage.into());
    }
    source.reject_part()?;
    let provenance = source.recording.provenance();
    let path = shown_path(source.recording.path());
    if provenance.stored == StoredFrames::All {
        let what = format!("{path} has all frames");
        return Err(VerifyError::Arguments(Message::new(what, "there is nothing to fill")));
    }
    match provenance.outcome {
        Some(Outcome::Complete | Outcome::Fault(_)) => Ok(()),
        Some(Outcome::Interrupted) | None => Err(VerifyError::Unsuitable(Message::new(
            format!("{path} is not finished or damaged at its end"),
            "run its manifest again to finish it",
        ))),
    }
}

/// The name that the recording of all frames has: the run key at the end of the name is replaced.
fn default_output(source: &Source, key: &str) -> PathBuf {
    let (path, own) = (source.recording.path(), &source.recording.provenance().run_key);
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let renamed = RunKey::from_hex(key).and_then(|key| key.in_place_of(own, &stem));
    let stem = renamed.unwrap_or_else(|| format!("{stem}.full"));
    path.with_file_name(format!("{stem}.mcap"))
}
