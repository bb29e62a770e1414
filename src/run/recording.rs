//! Opens recordings with the sizes that their manifests allow.

use kinetoscope_manifest::parse_run;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::Recording;
use std::path::Path;

/// Opens a recording whose frames have at most the particles of its manifest. A manifest that this version cannot read gives no
/// limit of its own.
///
/// # Errors
/// As [`Recording::open`].
pub fn open(path: &Path) -> Result<Recording, ReadError> {
    let recording = Recording::open(path)?;
    let run = parse_run(recording.manifest()).ok();
    Ok(match run.and_then(|run| run.particles_of_frames()) {
        Some(particles) => recording.with_max_particles(particles),
        None => recording,
    })
}
