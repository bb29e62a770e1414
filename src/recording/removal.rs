//! Removal of the files of a run while no other process writes it.

use crate::checkpoint;
use crate::error::RecordError;
use crate::file::{at, final_path, locked, partial_path};
use kinetoscope_files::atomic_file::remove_if_exists;
use std::path::Path;

/// Whether the files of a run were removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Removal {
    /// They do not exist any more.
    Removed,
    /// Another process writes the run: all its files are as they were.
    InUse,
}

/// Removes the partial file and the checkpoint of a recording, unless another process writes the file.
///
/// # Errors
/// A folder that cannot be written, or a partial file that is not a regular file.
pub fn remove_leftovers(folder: &Path, stem: &str) -> Result<Removal, RecordError> {
    if !partial_path(folder, stem).exists() && !checkpoint::exists(folder, stem) {
        return Ok(Removal::Removed);
    }
    remove_locked(folder, stem, || Ok(()))
}

/// Removes a recording, its side files with these extensions and its leftovers, unless another process writes the recording
/// again. The recording goes after its side files: a kill in between leaves it for the next removal.
///
/// # Errors
/// As [`remove_leftovers`].
pub fn remove_recording(
    folder: &Path,
    stem: &str,
    side_files: &[&str],
) -> Result<Removal, RecordError> {
    let recording = final_path(folder, stem);
    let side_files = side_files.iter().map(|end| recording.with_extension(end));
    remove_locked(folder, stem, || {
        for path in side_files.chain([recording.clone()]) {
            remove_if_exists(&path).map_err(|error| at(&path, &error))?;
        }
        Ok(())
    })
}

/// Removes files of a run and its leftovers while no other process can write the run. The partial file, which has the lock, goes
/// last: a kill before that leaves a partial file, from which the run starts again.
fn remove_locked(
    folder: &Path,
    stem: &str,
    others: impl FnOnce() -> Result<(), RecordError>,
) -> Result<Removal, RecordError> {
    let partial = partial_path(folder, stem);
    let existed = partial.exists();
    let _lock = match locked(&partial) {
        Ok(file) => file,
        Err(RecordError::Locked { .. }) => return Ok(Removal::InUse),
        Err(error) => return Err(error),
    };
    let removed = others().and_then(|()| checkpoint::remove(folder, stem));
    // A file that was created for its lock is no leftover.
    if removed.is_ok() || !existed {
        remove_if_exists(&partial).map_err(|error| at(&partial, &error))?;
    }
    removed.map(|()| Removal::Removed)
}
