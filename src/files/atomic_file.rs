//! Replacement of a whole file: a reader sees the old contents or the new ones, and a crash leaves one of the two.

use crate::folder::{folder_of, sync_folder};
use kinetoscope_console::text::shown_path;
use std::ffi::OsString;
use std::fs::{self, DirEntry, File, Metadata};
use std::io::{self, BufWriter, IntoInnerError, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::NamedTempFile;

/// How the names of temporary files begin and end.
const TEMPORARY: [&str; 2] = [".kinetoscope-", ".tmp"];
/// Age of a temporary file from which no process writes it any more.
const LEFTOVER_AGE: Duration = Duration::from_hours(24);
/// The permissions of any new file.
const NEW_FILE: u32 = 0o666;
/// The permissions of a file that only its owner can write.
const OWN_FILE: u32 = 0o644;

/// Replaces a file by these contents, which are on the disk when the function returns. Several processes may replace the same
/// file at once: each writes a temporary file of its own, and the last rename counts.
///
/// # Errors
/// A folder that cannot be written, or a disk that fails.
pub fn replace(path: &Path, contents: &[u8]) -> io::Result<()> {
    let temporary = temporary_file(path, contents, NEW_FILE)?;
    temporary.as_file().sync_all()?;
    temporary.persist(path)?;
    sync_folder(path)
}

/// A file that is written piece by piece. It replaces the file of this name, or a link or pipe in its place, when it is complete,
/// and is removed if it is dropped before. It is not synced.
#[derive(Debug)]
pub struct NewFile {
    file: BufWriter<NamedTempFile>,
    path: PathBuf,
}

impl NewFile {
    /// Begins a file that will be at `path`.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self {
            file: BufWriter::new(temporary_file(path, &[], NEW_FILE)?),
            path: path.to_owned(),
        })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// A folder that cannot be written, or a folder of this name.
    pub fn finish(self) -> io::Result<()> {
        self.file.into_inner().map_err(IntoInnerError::into_error)?.persist(&self.path)?;
        Ok(())
    }

    /// As [`NewFile::finish`]; the file is on the disk when the function returns.
    ///
    /// # Errors
    /// A folder that cannot be written, a folder of this name, or a disk that fails.
    pub fn finish_synced(self) -> io::Result<()> {
        let file = self.file.into_inner().map_err(IntoInnerError::into_error)?;
        file.as_file().sync_all()?;
        file.persist(&self.path)?;
        sync_folder(&self.path)
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// As [`replace`], but the contents may be lost if the machine fails: the sync of a file takes longer than a short run.
///
/// # Errors
/// A folder that cannot be written.
pub fn replace_unsynced(path: &Path, contents: &[u8]) -> io::Result<()> {
    temporary_file(path, contents, NEW_FILE)?.persist(path)?;
    Ok(())
}

/// As [`replace_unsynced`], for a file that only its owner can write, whatever other new files allow: see
/// [`crate::regular_file::read_own`].
///
/// # Errors
/// A folder that cannot be written.
pub fn replace_own_unsynced(path: &Path, contents: &[u8]) -> io::Result<()> {
    temporary_file(path, contents, OWN_FILE)?.persist(path)?;
    Ok(())
}

/// A new file with these contents next to `path`, with these permissions (on Unix) as far as the user's mask allows them. It is
/// removed if it is dropped.
fn temporary_file(path: &Path, contents: &[u8], permissions: u32) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    // A short name, because that of the file may be as long as the file system allows.
    builder.prefix(TEMPORARY[0]).suffix(TEMPORARY[1]);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(permissions));
    #[cfg(not(unix))]
    let _ = permissions;
    let folder = folder_of(path);
    let mut file = builder.tempfile_in(folder).map_err(|error| of_folder(folder, &error))?;
    file.write_all(contents)?;
    Ok(file)
}

/// Why no file can be created in a folder, without the name of the temporary file.
fn of_folder(folder: &Path, error: &io::Error) -> io::Error {
    let kind = error.kind();
    let folder = shown_path(folder);
    match kind {
        io::ErrorKind::NotFound => {
            io::Error::new(kind, format!("the folder {folder} does not exist"))
        }
        io::ErrorKind::NotADirectory => io::Error::new(kind, format!("{folder} is no folder")),
        _ => {
            // `tempfile` adds the path of the file, and no method returns the error without it.
            let text = error.to_string();
            let reason = text.split(" at path \"").next().unwrap_or_default();
            io::Error::new(kind, format!("no file can be created in {folder}: {reason}"))
        }
    }
}

/// Checks that a file can be created in the folder of `path`.
///
/// # Errors
/// A folder that does not exist or cannot be written.
pub fn check_folder(path: &Path) -> io::Result<()> {
    temporary_file(path, &[], OWN_FILE).map(drop)
}

/// The temporary files that killed processes left in a folder, sorted: those that no process has written for a day.
#[must_use]
pub fn leftovers(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let is_old = |entry: &DirEntry| {
        let changed = entry.metadata().ok().filter(Metadata::is_file)?.modified().ok()?;
        changed.elapsed().ok().map(|age| age > LEFTOVER_AGE)
    };
    let is_leftover = |entry: &DirEntry| {
        let [start, end] = TEMPORARY.map(str::as_bytes);
        let name = entry.file_name();
        let name = name.as_encoded_bytes();
        name.starts_with(start) && name.ends_with(end) && is_old(entry) == Some(true)
    };
    let entries = entries.filter_map(Result::ok).filter(is_leftover);
    let mut found: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    found.sort();
    found
}

/// Replaces a file by what `write` writes and returns. The caller holds a lock that excludes all other writers of this file, so
/// that the temporary file has a fixed name and the leftover of a kill is found.
///
/// # Errors
/// Those of `write`, a folder that cannot be written, or a disk that fails.
pub fn replace_locked(path: &Path, write: impl FnOnce(File) -> io::Result<File>) -> io::Result<()> {
    let temporary = temporary_path(path);
    // A new file: the leftover may be a symbolic link, which must not be followed.
    remove_if_exists(&temporary)?;
    write(File::create_new(&temporary)?)?.sync_all()?;
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

/// The file that [`replace_locked`] writes before it replaces `path`.
pub fn temporary_path(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".tmp");
    PathBuf::from(name)
}
