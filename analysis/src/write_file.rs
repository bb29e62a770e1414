//! Writes whole files: next to their place first, then moved there, so that no reader sees half of one.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// A file or folder that cannot be written, with the user's next step.
#[derive(Debug, thiserror::Error)]
#[error(
    "{} cannot be written: {reason}. Make room or make it writable, or name another folder with --output DIR",
    path.display()
)]
pub(crate) struct WriteError {
    path: PathBuf,
    reason: String,
}

impl WriteError {
    pub(crate) fn new(path: &Path, reason: impl std::fmt::Display) -> Self {
        Self { path: path.to_path_buf(), reason: reason.to_string() }
    }
}

/// Creates a folder and its parents.
///
/// # Errors
/// A folder that cannot be created.
pub(crate) fn create_folder(folder: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(folder).map_err(|error| WriteError::new(folder, error))
}

/// Writes a file next to its place and then moves it there.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn replace(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".new");
    let temporary = path.with_file_name(name);
    let write = || -> io::Result<()> {
        std::fs::write(&temporary, content)?;
        std::fs::rename(&temporary, path)
    };
    write().map_err(|error| WriteError::new(path, error))
}

/// Adds text to the end of a file, which is created if it does not exist.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn append(path: &Path, text: &str) -> Result<(), WriteError> {
    let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
    file.and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|error| WriteError::new(path, error))
}
