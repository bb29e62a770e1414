//! What `fill` and `zoom` share: a recording whose run is executed again, errors, and the file of the result.

use crate::interrupt::Interrupt;
use crate::plan::restart_files::StartFiles;
use crate::run::prepared::Prepared;
use crate::run::{RunError, recording};
use crate::verify::rerun_check::Findings;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::folder::folder_of;
use kinetoscope_files::output_file;
use kinetoscope_manifest::{RunManifest, parse_run, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_physics::model::SetupError;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use kinetoscope_recording::error::{ReadError, RecordError};
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::reader::Recording;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The reason why frames were not restored.
#[derive(Debug, Error)]
pub enum RestoreError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// This version of the program does not accept the manifest; all errors are listed.
    #[error(
        "this version does not understand the manifest in the recording; use the version that wrote it\n{0}"
    )]
    Manifest(String),
    /// The recording from which the run started is missing.
    #[error("the run started from another recording: {0}")]
    Start(String),
    /// The physics of this program is another one.
    #[error(
        "{path} was recorded with physics version {recorded} of {model}, and this program has version {own}: its frames can only be \
         restored by a program with version {recorded}, but its keyframes can be viewed with any",
        path = shown_path(.path)
    )]
    OtherPhysics {
        /// The recording.
        path: PathBuf,
        /// Name of the model.
        model: String,
        /// The version in the recording.
        recorded: u32,
        /// The version of this program.
        own: u32,
    },
    /// Arguments that do not fit the recording.
    #[error("{0}")]
    Arguments(String),
    /// The recording cannot be used for this purpose.
    #[error("{0}")]
    Unsuitable(String),
    /// The rerun gives other messages.
    #[error("the rerun differs from {path} in frame {frame}, {channel}: the file was changed, or another program wrote it; compare \
         versions with `kinetoscope info`", path = shown_path(.path))]
    Differs {
        /// The recording.
        path: PathBuf,
        /// The first frame that differs.
        frame: u64,
        /// The first channel that differs in this frame.
        channel: String,
    },
    /// The rerun failed.
    #[error("the rerun failed: {0}")]
    Run(RunError),
    /// The result cannot be written.
    #[error(transparent)]
    Write(RecordError),
    /// The program received a signal.
    #[error("stopped before the end, nothing was written; run the same command again")]
    Interrupted(u8),
}

impl From<RecordError> for RestoreError {
    fn from(error: RecordError) -> Self {
        Self::Write(error)
    }
}

impl From<SetupError> for RestoreError {
    fn from(error: SetupError) -> Self {
        Self::Run(error.into())
    }
}

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

/// A recording whose run this program can execute again.
pub(crate) struct Source {
    pub(crate) recording: Recording,
    /// The run, with the same record.
    pub(crate) manifest: RunManifest,
}

impl Source {
    /// Opens a recording and checks its versions.
    pub(crate) fn open(path: &Path) -> Result<Self, RestoreError> {
        let recording = recording::open(path)?;
        let provenance = recording.provenance();
        let mut manifest = parse_run(recording.manifest())
            .map_err(|diagnostics| RestoreError::Manifest(diagnostics.render(false)))?;
        let (recorded, own) =
            (provenance.physics_version, kind_of(&manifest.model).physics_version);
        if recorded != own {
            let (path, model) = (path.to_owned(), provenance.model.clone());
            return Err(RestoreError::OtherPhysics { path, model, recorded, own });
        }
        let starts = StartFiles::relative_to(folder_of(path));
        manifest.model.read_start(&|name: &str| starts.read(name)).map_err(RestoreError::Start)?;
        Ok(Self { recording, manifest })
    }

    /// Reads the recording to its end; returns why a part of it cannot be read.
    pub(crate) fn damage(&self, interrupt: &Interrupt) -> Result<Option<ReadError>, RestoreError> {
        for frame in self.recording.frames()? {
            if let Some(code) = interrupt.exit_code() {
                return Err(RestoreError::Interrupted(code));
            }
            if let Err(error) = frame {
                return Ok(Some(error));
            }
        }
        Ok(None)
    }

    /// The start of the run, with all frames recorded.
    pub(crate) fn start(&self) -> Result<Prepared, RestoreError> {
        let manifest = self.manifest.with_all_frames();
        let (canonical, key) = self.identity(&manifest);
        Ok(Prepared::new(&manifest, &canonical, &key)?)
    }

    pub(crate) fn path(&self) -> &Path {
        self.recording.path()
    }

    /// The canonical text of a manifest of this run, and its run key.
    pub(crate) fn identity(&self, manifest: &RunManifest) -> (String, String) {
        let canonical = manifest.canonical();
        let physics = kind_of(&manifest.model).physics_version;
        let key = run_key(&canonical, physics, SCHEMA_VERSION).as_str().to_owned();
        (canonical, key)
    }

    /// Rejects a file that cannot be written, or exists and is not the result of an earlier call, before the run is executed.
    pub(crate) fn check_output(&self, path: &Path, key: &str) -> Result<(), RestoreError> {
        if path.is_dir() || stem_of(path).is_none() {
            return Err(RestoreError::Arguments(format!(
                "{} is not the name of a file that ends in .mcap\nhelp: name one, such as --output all.mcap",
                shown_path(path)
            )));
        }
        let is_result =
            |path| recording::open(path).is_ok_and(|existing| existing.provenance().run_key == key);
        if !path.exists() || is_result(path) {
            return output_file::check(path).map_err(|error| unwritten(path, &error));
        }
        let own =
            if same_file(path, self.path()) { "the recording itself" } else { "another file" };
        let what = format!(
            "{} exists, and is {own}\nhelp: name a new file with --output",
            shown_path(path)
        );
        Err(RestoreError::Arguments(what))
    }

    /// The error of a check, if it found a difference.
    pub(crate) fn differences(&self, findings: &mut Findings) -> Result<(), RestoreError> {
        match findings.mismatch.take() {
            Some((frame, channel)) => {
                Err(RestoreError::Differs { path: self.path().to_owned(), frame, channel })
            }
            None => Ok(()),
        }
    }
}

fn same_file(one: &Path, other: &Path) -> bool {
    matches!((one.canonicalize(), other.canonicalize()), (Ok(one), Ok(other)) if one == other)
}

/// The error of a result that cannot be written.
fn unwritten(path: &Path, error: &io::Error) -> RestoreError {
    let what = format!("{} cannot be written: {error}", shown_path(path));
    if output_file::is_of_path(error) {
        return RestoreError::Arguments(format!("{what}\nhelp: name another file with --output"));
    }
    RestoreError::Write(RecordError::Io(io::Error::new(error.kind(), what)))
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
    write: impl FnOnce(RecordingFile) -> Result<T, RestoreError>,
) -> Result<T, RestoreError> {
    let stem = stem_of(path).unwrap_or_default();
    let file = RecordingFile::create_or_continue(folder_of(path), stem)?;
    let (partial, kept) = (file.partial_path().to_owned(), file.kept());
    write(file).map_err(|error| match error {
        _ if kept == 0 && !matches!(record_error(&error), Some(RecordError::Differs { .. })) => {
            // What remains is continued by the next attempt.
            let _ = fs::remove_file(&partial);
            error
        }
        _ if kept > 0 && is_other_content(&error) => RestoreError::Arguments(format!(
            "{} exists, and is not the beginning of the result\nhelp: remove it, or name a new file with --output",
            shown_path(&partial)
        )),
        error => error,
    })
}

fn record_error(error: &RestoreError) -> Option<&RecordError> {
    match error {
        RestoreError::Write(error) | RestoreError::Run(RunError::Record(error)) => Some(error),
        _ => None,
    }
}

/// Whether an existing partial file has other bytes than the result.
fn is_other_content(error: &RestoreError) -> bool {
    match record_error(error) {
        Some(RecordError::Io(error)) => error.kind() == io::ErrorKind::InvalidData,
        Some(RecordError::NotContinued { .. }) => true,
        _ => false,
    }
}
