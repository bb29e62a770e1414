//! The file of a result of `fill` and `zoom`.

use crate::run::recording;
use crate::verify::error::VerifyError;
use crate::verify::source::Source;
use kinetoscope_console::Message;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::folder::folder_of;
use kinetoscope_files::output_file;
use kinetoscope_recording::error::{ReadError, RecordError};
use kinetoscope_recording::file::RecordingFile;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The result of `fill` or `zoom`.
#[derive(Debug)]
pub struct Restored {
    /// The file.
    pub path: PathBuf,
    /// Its number of frames.
    pub frames: u64,
    /// Number of recorded frames whose messages were computed again and are equal.
    pub equal_frames: u64,
    /// What the user should know.
    pub notes: Vec<String>,
    /// Why a part of the recording cannot be read.
    pub damage: Option<ReadError>,
}

/// Rejects a file that cannot be written, or exists and is not the result of an earlier call, before the run is executed.
pub(crate) fn check_output(source: &Source, path: &Path, key: &str) -> Result<(), VerifyError> {
    let shown = shown_path(path);
    if path.is_dir() || stem_of(path).is_none() {
        return Err(VerifyError::Arguments(Message::new(
            format!("{shown} is not the name of a file that ends in .mcap"),
            "name one, such as --output all.mcap",
        )));
    }
    let is_result =
        |path| recording::open(path).is_ok_and(|existing| existing.provenance().run_key == key);
    if !path.exists() || is_result(path) {
        return output_file::check(path).map_err(|error| unwritten(path, &error, "--output"));
    }
    let is_source = same_file(path, source.recording.path());
    let own = if is_source { "the recording itself" } else { "another file" };
    Err(VerifyError::Arguments(Message::new(
        format!("{shown} exists, and is {own}"),
        "name a new file with --output",
    )))
}

fn same_file(one: &Path, other: &Path) -> bool {
    matches!((one.canonicalize(), other.canonicalize()), (Ok(one), Ok(other)) if one == other)
}

/// The error of a file that cannot be written and was named by an option.
pub(crate) fn unwritten(path: &Path, error: &io::Error, option: &str) -> VerifyError {
    let what = format!("{} cannot be written: {error}", shown_path(path));
    if output_file::is_of_path(error) {
        let help = format!("name another file with {option}");
        return VerifyError::Arguments(Message::new(what, help));
    }
    VerifyError::Write(RecordError::Io(io::Error::new(error.kind(), what)))
}

/// The name of a result without its ending; `None` if it has none, or another ending.
fn stem_of(path: &Path) -> Option<&str> {
    let stem = path.file_name()?.to_str()?.strip_suffix(".mcap")?;
    (!stem.is_empty()).then_some(stem)
}

/// Creates the file of the result and writes it: a partial file beside it until it is complete. An existing partial file, such as
/// that of a call that was killed or of an interrupted run, is continued if it is the beginning of the result, and otherwise
/// kept: it is of another program or run. A new one that does not become complete is removed, unless it differs from an existing
/// recording, because the error names both.
pub(crate) fn written<T>(
    path: &Path,
    write: impl FnOnce(RecordingFile) -> Result<T, VerifyError>,
) -> Result<T, VerifyError> {
    let stem = stem_of(path).unwrap_or_default();
    let file = RecordingFile::create_or_continue(folder_of(path), stem)?;
    let (partial, kept) = (file.partial_path().to_owned(), file.kept());
    write(file).map_err(|error| match error {
        _ if kept == 0 && !matches!(error, VerifyError::Write(RecordError::Differs { .. })) => {
            // What remains is continued by the next attempt.
            let _ = fs::remove_file(&partial);
            error
        }
        _ if kept > 0 && is_other_content(&error) => VerifyError::Arguments(Message::new(
            format!("{} exists, and is not the beginning of the result", shown_path(&partial)),
            "remove it, or name a new file with --output",
        )),
        error => error,
    })
}

/// Whether an existing partial file has other bytes than the result.
fn is_other_content(error: &VerifyError) -> bool {
    match error {
        VerifyError::Write(RecordError::Io(error)) => error.kind() == io::ErrorKind::InvalidData,
        VerifyError::Write(RecordError::NotContinued { .. }) => true,
        _ => false,
    }
}
