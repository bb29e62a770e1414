//! A recording and what it takes to execute its run again.

use crate::interrupt::Interrupt;
use crate::run::prepared::Prepared;
use crate::run::recording;
use crate::run::restart_files::StartFiles;
use crate::verify::error::VerifyError;
use kinetoscope_console::Message;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::folder::folder_of;
use kinetoscope_manifest::{RunManifest, parse_run, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_physics::model::SetupError;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::file::is_being_written;
use kinetoscope_recording::reader::{Recording, StoredFrames};
use std::path::Path;
use std::sync::Arc;

/// A recording whose run this program can execute again.
pub(crate) struct Source {
    pub(crate) recording: Recording,
    /// The run, with the same record, and with the state from which it started.
    pub(crate) manifest: RunManifest,
}

impl Source {
    /// Opens a recording that no process is writing.
    pub(crate) fn open(path: &Path) -> Result<Self, VerifyError> {
        let source = Self::of(&recording::open(path)?)?;
        source.reject_growing()?;
        Ok(source)
    }

    /// Reads the manifest of a recording, and the recording from which its run started.
    pub(crate) fn of(recording: &Recording) -> Result<Self, VerifyError> {
        let mut manifest = parse_run(recording.manifest())
            .map_err(|diagnostics| VerifyError::Manifest(diagnostics.render(false)))?;
        let starts = StartFiles::relative_to(folder_of(recording.path()));
        let model = Arc::make_mut(&mut manifest.model);
        model.read_start(&|name: &str| starts.read(name)).map_err(VerifyError::Start)?;
        Ok(Self { recording: recording.clone(), manifest })
    }

    /// Rejects a recording that another process is writing: what is missing would be taken for a difference.
    fn reject_growing(&self) -> Result<(), VerifyError> {
        let path = self.recording.path();
        if self.recording.provenance().outcome.is_some() || !is_being_written(path) {
            return Ok(());
        }
        let what = format!("{} is being written by another process", shown_path(path));
        Err(VerifyError::Unsuitable(Message::new(what, "wait for the end of its run")))
    }

    /// The physics version that this program has for the model of the run.
    pub(crate) fn own_physics_version(&self) -> u32 {
        kind_of(&self.manifest.model).physics_version
    }

    /// Rejects a recording of another physics, whose frames this program cannot restore.
    pub(crate) fn reject_other_physics(&self) -> Result<(), VerifyError> {
        let provenance = self.recording.provenance();
        let (recorded, own) = (provenance.physics_version, self.own_physics_version());
        if recorded == own {
            return Ok(());
        }
        let (path, model) = (self.recording.path().to_owned(), provenance.model.clone());
        Err(VerifyError::OtherPhysics { path, model, recorded, own })
    }

    /// Rejects a recording that has only a part of its run.
    pub(crate) fn reject_part(&self) -> Result<(), VerifyError> {
        let StoredFrames::From(_) = self.recording.provenance().stored else { return Ok(()) };
        Err(VerifyError::Arguments(Message::new(
            format!("{} is a part of a run", shown_path(self.recording.path())),
            "name the recording of the whole run",
        )))
    }

    /// The start of the run, with the frames and the run key of the recording.
    pub(crate) fn prepared(&self, interrupt: &Interrupt) -> Result<Prepared, VerifyError> {
        let run_key = &self.recording.provenance().run_key;
        let canonical = self.recording.manifest();
        unless_interrupted(Prepared::new(&self.manifest, canonical, run_key, interrupt), interrupt)
    }

    /// The start of the run, with all frames recorded.
    pub(crate) fn prepared_with_all_frames(
        &self,
        interrupt: &Interrupt,
    ) -> Result<Prepared, VerifyError> {
        let manifest = self.manifest.with_all_frames();
        let (canonical, key) = self.identity(&manifest);
        unless_interrupted(Prepared::new(&manifest, &canonical, &key, interrupt), interrupt)
    }

    /// The canonical text of a manifest of this run, and its run key.
    pub(crate) fn identity(&self, manifest: &RunManifest) -> (String, String) {
        let canonical = manifest.canonical();
        let key = run_key(&canonical, self.own_physics_version(), SCHEMA_VERSION);
        (canonical, key.as_str().to_owned())
    }
}

/// The start of a run, or the signal that stopped it.
fn unless_interrupted(
    start: Result<Prepared, SetupError>,
    interrupt: &Interrupt,
) -> Result<Prepared, VerifyError> {
    match (start, interrupt.exit_code()) {
        (Err(_), Some(code)) => Err(VerifyError::Interrupted(code)),
        (start, _) => Ok(start?),
    }
}

/// The readable part of a recording, whose file may be damaged behind it.
pub(crate) struct ReadablePart {
    /// Number of frames with all channels.
    pub(crate) frames: u64,
    /// Index of the last frame, of which at least the scalars are stored.
    pub(crate) last: u64,
    /// Why the rest cannot be read.
    pub(crate) damage: Option<ReadError>,
}

impl ReadablePart {
    /// Reads a recording to its end.
    pub(crate) fn of(source: &Source, interrupt: &Interrupt) -> Result<Self, VerifyError> {
        let mut part = Self { frames: 0, last: 0, damage: None };
        for frame in source.recording.frames()?.with_scalar_frames() {
            if let Some(code) = interrupt.exit_code() {
                return Err(VerifyError::Interrupted(code));
            }
            match frame {
                Ok(frame) => {
                    part.frames += u64::from(frame.is_complete());
                    part.last = frame.clock.frame;
                }
                Err(error) => {
                    // A run may have been resumed meanwhile.
                    source.reject_growing()?;
                    part.damage = Some(error);
                    break;
                }
            }
        }
        Ok(part)
    }
}
