//! Files that the user names as a destination: they may be links, devices or pipes, and are written as any program would write
//! them. No call waits for a reader that does not exist.

use crate::atomic_file::{check_folder, replace};
use crate::folder::folder_of;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write as _};
use std::path::Path;

/// Writes a destination: a regular file is replaced as a whole, behind a symbolic link as well; a device or a pipe receives the
/// bytes.
///
/// # Errors
/// A folder that cannot be written, a destination that fails, or a named pipe without a reader.
pub fn write(path: &Path, contents: &[u8]) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(metadata) if !metadata.is_file() && !metadata.is_dir() => {
            open_special(path)?.write_all(contents)
        }
        Ok(_) if path.is_symlink() => replace(&fs::canonicalize(path)?, contents),
        // The target of a dangling link is created.
        Err(_) if path.is_symlink() => fs::write(path, contents),
        Ok(_) | Err(_) => replace(path, contents),
    }
}

/// Checks that a destination can be written, before the work whose result it receives.
///
/// # Errors
/// A folder of this name, or a folder above it that does not exist or cannot be written.
pub fn check(path: &Path) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => {
            Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"))
        }
        Ok(metadata) if !metadata.is_file() => Ok(()),
        Ok(_) if path.is_symlink() => check_folder(&fs::canonicalize(path)?),
        // What becomes of a dangling link is known when it is written.
        Err(_) if path.is_symlink() => Ok(()),
        Ok(_) | Err(_) => check_folder(path),
    }
}

/// Excludes other processes that read a file, change it and write it again, as long as this value exists. The folder is locked, because
/// the file is replaced; no file of the lock remains, whichever way the process ends.
#[derive(Debug)]
pub struct FolderLock {
    /// `None` if the folder cannot be locked: on Windows, on some network file systems, and without permission to read it.
    _folder: Option<File>,
}

impl FolderLock {
    /// Locks the folder of a file, behind a symbolic link as well; `None` while another process does.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let file = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let opened = if cfg!(unix) { File::open(folder_of(&file)).ok() } else { None };
        match opened.as_ref().map(File::try_lock) {
            Some(Ok(())) => Some(Self { _folder: opened }),
            Some(Err(TryLockError::WouldBlock)) => None,
            Some(Err(TryLockError::Error(_))) | None => Some(Self { _folder: None }),
        }
    }
}

/// Checks that files can be written in a folder, which need not exist yet, before the work whose results it receives.
///
/// # Errors
/// A file in the way, or a folder that cannot be written.
pub fn check_results_folder(folder: &Path) -> io::Result<()> {
    let exists = |path: &&Path| path.as_os_str().is_empty() || path.symlink_metadata().is_ok();
    let existing = folder.ancestors().find(exists).unwrap_or(Path::new(""));
    check_folder(&existing.join("results"))
}

/// Whether an error follows from the path that the user named, so that the same command fails again. A folder that is read-only may
/// become writable.
#[must_use]
pub fn is_of_path(error: &io::Error) -> bool {
    use io::ErrorKind as Kind;
    matches!(
        error.kind(),
        Kind::NotFound
            | Kind::NotADirectory
            | Kind::IsADirectory
            | Kind::AlreadyExists
            | Kind::InvalidFilename
            | Kind::InvalidInput
    )
}

/// Adds text to the end of a destination, which is created if it does not exist.
///
/// # Errors
/// As [`write()`].
pub fn append(path: &Path, text: &str) -> io::Result<()> {
    let is_special =
        fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir());
    let mut file = if is_special {
        open_special(path)?
    } else {
        OpenOptions::new().create(true).append(true).open(path)?
    };
    file.write_all(text.as_bytes())
}

/// Opens a device or a pipe. A named pipe without a reader is an error at once.
#[cfg(unix)]
fn open_special(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt as _;
    let mut options = OpenOptions::new();
    options.write(true).custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY);
    let probe = options.open(path).map_err(|error| match error.raw_os_error() {
        Some(libc::ENXIO) => io::Error::other("it is a named pipe that no program reads"),
        _ => error,
    })?;
    if !std::os::unix::fs::FileTypeExt::is_fifo(&probe.metadata()?.file_type()) {
        return Ok(probe);
    }
    // The pipe has a reader, so a second open does not block, and writes wait for the reader.
    OpenOptions::new().write(true).open(path)
}

#[cfg(not(unix))]
fn open_special(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).open(path)
}
