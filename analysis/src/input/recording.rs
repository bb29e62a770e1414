//! One open recording with its manifest.

use crate::input::error::UnreadableRecording;
use crate::metric::RunOrigin;
use kinetoscope_console::text::shown_path;
use kinetoscope_manifest::{RunKey, RunManifest, parse_run, run_key};
use kinetoscope_recording::reader::{Provenance, Recording, StoredFrames};
use std::path::{Path, PathBuf};

/// An open recording and its manifest.
pub struct OpenRun {
    recording: Recording,
    /// The file name without its folder.
    pub(crate) file: String,
    /// The run's manifest.
    pub(crate) manifest: RunManifest,
    /// The run's run key.
    pub(crate) run_key: String,
}

impl OpenRun {
    /// A recording with the manifest that it contains.
    pub(crate) fn of(recording: Recording, manifest: RunManifest) -> Self {
        let name = recording.path().file_name();
        let file = name.map_or_else(String::new, |name| name.to_string_lossy().into());
        let run_key = recording.provenance().run_key.clone();
        Self { recording: limited(recording, &manifest), file, manifest, run_key }
    }

    /// The recording.
    pub(crate) fn recording(&self) -> &Recording {
        &self.recording
    }

    /// The distance of the keyframes, in frames, and the command that restores the frames between them; `None` if all frames are stored.
    pub(crate) fn keyframes(&self) -> Option<(u64, String)> {
        match self.recording.provenance().stored {
            StoredFrames::Keyframes(distance) if distance.get() > 1 => {
                let path = shown_path(self.recording.path());
                Some((distance.get(), format!("kinetoscope fill {path}")))
            }
            _ => None,
        }
    }

    /// The run's identity and the programs behind it.
    pub(crate) fn origin(&self) -> RunOrigin {
        let provenance = self.recording.provenance();
        RunOrigin {
            run_key: self.run_key.clone(),
            program_version: provenance.program_version.clone(),
            physics_version: provenance.physics_version,
        }
    }
}

/// Opens a recording and reads its manifest.
///
/// # Errors
/// A file that is not a Kinetoscope recording, or an invalid manifest.
pub fn open(path: &Path) -> Result<OpenRun, UnreadableRecording> {
    opened(Recording::open(path).map_err(UnreadableRecording::from)?)
}

/// Reads the manifest of an open recording.
///
/// # Errors
/// An invalid manifest.
pub(crate) fn opened(recording: Recording) -> Result<OpenRun, UnreadableRecording> {
    check_whole_run(&recording)?;
    opened_with_its_frames(recording)
}

/// As [`opened`], for a recording that may hold a part of its run.
///
/// # Errors
/// An invalid manifest.
pub(crate) fn opened_with_its_frames(recording: Recording) -> Result<OpenRun, UnreadableRecording> {
    let path = recording.path();
    let manifest = parse_run(recording.manifest()).map_err(|diagnostics| {
        let path = shown_path(path);
        let errors = diagnostics.to_string();
        UnreadableRecording::new(
            format!(
                "{path}: its manifest is not one that this version reads; no frame was read\n{}",
                errors.trim_end()
            ),
            "use the program that wrote it",
        )
    })?;
    Ok(OpenRun::of(recording, manifest))
}

/// Rejects a recording that holds a part of its run: most metrics need its start.
fn check_whole_run(recording: &Recording) -> Result<(), UnreadableRecording> {
    let path = shown_path(recording.path());
    match recording.provenance().stored {
        StoredFrames::All | StoredFrames::Keyframes(_) => Ok(()),
        StoredFrames::From(_) => Err(UnreadableRecording::new(
            format!(
                "{path}: it is a part of a run, and metrics need all frames; no frame was read"
            ),
            "name the recording of the whole run",
        )),
    }
}

/// The file next to a recording of keyframes in which `kinetoscope fill` restores its run with all frames, and its run key.
pub(crate) fn restored_file(recording: &Recording) -> Option<(PathBuf, RunKey)> {
    let Provenance { stored, physics_version, schema_version, run_key: own, .. } =
        recording.provenance();
    let StoredFrames::Keyframes(_) = stored else { return None };
    let canonical = parse_run(recording.manifest()).ok()?.with_all_frames().canonical();
    let key = run_key(&canonical, *physics_version, *schema_version);
    let stem = key.in_place_of(own, recording.path().file_stem()?.to_str()?)?;
    Some((recording.path().with_file_name(format!("{stem}.mcap")), key))
}

/// Limits the frames of a recording to the particles of its manifest, if this version can read it.
pub(crate) fn with_frame_limit(recording: Recording) -> Recording {
    match parse_run(recording.manifest()) {
        Ok(run) => limited(recording, &run),
        Err(_) => recording,
    }
}

fn limited(recording: Recording, run: &RunManifest) -> Recording {
    match run.particles_of_frames() {
        Some(particles) => recording.with_max_particles(particles),
        None => recording,
    }
}

/// Whether a file name is that of a recording in progress.
pub(crate) fn is_partial(file: &str) -> bool {
    file.ends_with(".partial.mcap")
}
