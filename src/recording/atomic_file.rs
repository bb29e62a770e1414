//! Replacement of a whole file: a reader sees the old contents or the new ones, and a crash leaves one of the two.

use crate::file::sync_folder;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Replaces a file by these contents, which are on the disk when the function returns.
///
/// # Errors
/// A folder that cannot be written, or a disk that fails.
pub fn replace(path: &Path, contents: &[u8]) -> io::Result<()> {
    replace_with(path, |mut file| {
        file.write_all(contents)?;
        Ok(file)
    })
}

/// Replaces a file by what `write` writes and returns.
///
/// # Errors
/// Those of `write`, a folder that cannot be written, or a disk that fails.
pub(crate) fn replace_with(
    path: &Path,
    write: impl FnOnce(File) -> io::Result<File>,
) -> io::Result<()> {
    let temporary = temporary_path(path);
    write(File::create(&temporary)?)?.sync_all()?;
    fs::rename(&temporary, path)?;
    sync_folder(path)
}

/// Removes a file that may not exist.
///
/// # Errors
/// A folder that cannot be written.
pub fn remove_if_exists(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        Ok(()) | Err(_) => Ok(()),
    }
}

/// The file that is written before it replaces `path`.
pub(crate) fn temporary_path(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".tmp");
    PathBuf::from(name)
}
