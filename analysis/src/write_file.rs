//! Writes whole files, so that no reader sees half of one.

use kinetoscope_recording::atomic_file::{self, NewFile};
use kinetoscope_recording::output_file;
use kinetoscope_usage::text::shown_path;
use std::path::{Path, PathBuf};

/// A file or folder that cannot be written, with the user's next step.
#[derive(Debug, thiserror::Error)]
#[error(
    "{} cannot be written: {reason}. Make room or make it writable, or name another {instead}",
    shown_path(path)
)]
pub(crate) struct WriteError {
    path: PathBuf,
    reason: String,
    /// What the user may name in its place.
    instead: &'static str,
}

impl WriteError {
    pub(crate) fn new(path: &Path, reason: impl std::fmt::Display) -> Self {
        let instead = "folder with --output DIR";
        Self { path: path.to_path_buf(), reason: reason.to_string(), instead }
    }

    /// An error of a destination that the user named.
    fn of_destination(path: &Path, reason: impl std::fmt::Display) -> Self {
        Self { instead: "file", ..Self::new(path, reason) }
    }
}

/// Creates a folder and its parents.
///
/// # Errors
/// A folder that cannot be created.
pub(crate) fn create_folder(folder: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(folder).map_err(|error| WriteError::new(folder, error))
}

/// Replaces a file as a whole. A symbolic link is replaced, not followed: another user of the folder may have put it there.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn replace(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    atomic_file::replace(path, content.as_ref()).map_err(|error| WriteError::new(path, error))
}

/// As [`replace`], for one of many files: it may be lost if the machine fails.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn replace_unsynced(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    let replaced = atomic_file::replace_unsynced(path, content.as_ref());
    replaced.map_err(|error| WriteError::new(path, error))
}

/// Begins a file that is written piece by piece and then replaces the one of this name.
///
/// # Errors
/// A folder that cannot be written.
pub(crate) fn begin(path: &Path) -> Result<NewFile, WriteError> {
    NewFile::create(path).map_err(|error| WriteError::new(path, error))
}

/// Writes a destination that the user named, which may be a link, a device or a pipe.
///
/// # Errors
/// A destination that cannot be written.
pub(crate) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    output_file::write(path, content.as_ref())
        .map_err(|error| WriteError::of_destination(path, error))
}

/// Adds text to the end of a destination, which is created if it does not exist.
///
/// # Errors
/// A destination that cannot be written.
pub(crate) fn append(path: &Path, text: &str) -> Result<(), WriteError> {
    output_file::append(path, text).map_err(|error| WriteError::of_destination(path, error))
}
