//! Writes whole files, so that no reader sees half of one.

use kinetoscope_console::Explained;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::atomic_file::{self, NewFile};
use kinetoscope_files::output_file;
use std::io;
use std::path::{Path, PathBuf};

/// A file or folder that cannot be written, with the user's next step.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be written: {reason}", shown_path(path))]
pub(crate) struct WriteError {
    path: PathBuf,
    reason: String,
    /// What the user may do to the path.
    remedy: &'static str,
    /// What the user may name in its place.
    instead: &'static str,
    /// Whether the same command fails again, because the path is wrong.
    pub(crate) is_of_path: bool,
}

impl Explained for WriteError {
    fn help(&self) -> Option<String> {
        Some(format!("{}, or name another {}", self.remedy, self.instead))
    }
}

impl WriteError {
    pub(crate) fn new(path: &Path, reason: impl std::fmt::Display) -> Self {
        let (remedy, instead) = ("make room or make it writable", "folder with --output DIR");
        let (path, reason) = (path.to_path_buf(), reason.to_string());
        Self { path, reason, remedy, instead, is_of_path: false }
    }

    fn of(path: &Path, error: &io::Error) -> Self {
        let is_of_path = output_file::is_of_path(error);
        let new = Self { is_of_path, ..Self::new(path, error) };
        match error.kind() {
            io::ErrorKind::NotFound => Self { remedy: "create the folder", ..new },
            io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
                Self { remedy: "remove the file in the way", ..new }
            }
            _ => new,
        }
    }

    /// An error of a destination that the user named.
    fn of_destination(path: &Path, error: &io::Error) -> Self {
        Self { instead: "file", ..Self::of(path, error) }
    }
}

/// Creates a folder and its parents.
///
/// # Errors
/// A folder that cannot be created.
pub(crate) fn create_folder(folder: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(folder).map_err(|error| WriteError::of(folder, &error))
}

/// Replaces a file as a whole. A symbolic link is replaced, not followed: another user of the folder may have put it there.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn replace(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    atomic_file::replace(path, content.as_ref()).map_err(|error| WriteError::of(path, &error))
}

/// As [`replace`], for one of many files: it may be lost if the machine fails.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn replace_unsynced(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    let replaced = atomic_file::replace_unsynced(path, content.as_ref());
    replaced.map_err(|error| WriteError::of(path, &error))
}

/// Begins a file that is written piece by piece and then replaces the one of this name.
///
/// # Errors
/// A folder that cannot be written.
pub(crate) fn begin(path: &Path) -> Result<NewFile, WriteError> {
    NewFile::create(path).map_err(|error| WriteError::of(path, &error))
}

/// Writes a destination that the user named, which may be a link, a device or a pipe.
///
/// # Errors
/// A destination that cannot be written.
pub(crate) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    output_file::write(path, content.as_ref())
        .map_err(|error| WriteError::of_destination(path, &error))
}

/// Checks that a destination that the user named can be written, before the work whose result it receives.
///
/// # Errors
/// A destination that cannot be written.
pub(crate) fn check(path: &Path) -> Result<(), WriteError> {
    output_file::check(path).map_err(|error| WriteError::of_destination(path, &error))
}

/// Checks that a folder, which need not exist yet, can receive results, before the work that makes them.
///
/// # Errors
/// A file in the way, or a folder that cannot be written.
pub(crate) fn check_results_folder(folder: &Path) -> Result<(), WriteError> {
    output_file::check_results_folder(folder).map_err(|error| WriteError::of(folder, &error))
}

/// Adds text to the end of a destination, which is created if it does not exist.
///
/// # Errors
/// A destination that cannot be written.
pub(crate) fn append(path: &Path, text: &str) -> Result<(), WriteError> {
    output_file::append(path, text).map_err(|error| WriteError::of_destination(path, &error))
}
