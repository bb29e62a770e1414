//! The file of a recording. It has a partial name while it is written and gets its final name only when it is complete.

use crate::error::{ReadFault, RecordError};
use crate::reader::Recording;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::folder::sync_folder;
use kinetoscope_files::regular_file;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

/// Number of attempts to open a file that another process may rename, or lock for an instant, meanwhile.
const LOCK_TRIALS: u32 = 8;
/// Time before the next attempt, if it is locked.
const BETWEEN_TRIALS: Duration = Duration::from_millis(5);
/// Number of bytes between two syncs, so that the last sync at the end of a run is short.
const SYNCED_EVERY: u64 = 16 << 20;
/// Size of the parts in which two files are compared.
const COMPARED_AT_ONCE: u64 = 1 << 20;

/// `STEM.partial.mcap` while it is written; `STEM.mcap` after [`RecordingFile::commit`].
///
/// Invariant: the file is locked while this value exists, so that two processes never write the same recording.
pub struct RecordingFile {
    file: File,
    partial: PathBuf,
    destination: PathBuf,
    /// Position of the next byte.
    position: u64,
    /// Number of existing bytes. Bytes written up to here are compared with them; later bytes extend the file.
    kept: u64,
    compared: Vec<u8>,
    /// Number of bytes since the last sync.
    unsynced: u64,
}

/// Whether the final name was free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Committed {
    /// The file was renamed.
    New,
    /// A recording with the same bytes existed.
    AlreadyThere,
    /// A damaged recording had the name. It was kept as `STEM.mcap.damaged`.
    Replaced,
}

impl RecordingFile {
    /// Creates an empty partial file; an existing one is truncated.
    ///
    /// # Errors
    /// A folder that cannot be written, or another process that writes the same recording.
    pub fn create(folder: &Path, stem: &str) -> Result<Self, RecordError> {
        let file = Self::open(folder, stem, 0)?;
        file.file.set_len(0).map_err(|error| at(&file.partial, &error))?;
        Ok(file)
    }

    /// Resumes a partial file after its first `kept` bytes. The caller writes these bytes again; they are compared with the existing
    /// ones, and the rest of the file is then truncated.
    ///
    /// # Errors
    /// A file that is shorter or cannot be opened, or another process that writes the same recording.
    pub fn reopen(folder: &Path, stem: &str, kept: u64) -> Result<Self, RecordError> {
        let file = Self::open(folder, stem, kept)?;
        let length = file.file.metadata().map_err(|error| at(&file.partial, &error))?.len();
        if length < kept {
            let what = format!("it has {length} bytes, the checkpoint counts on {kept}");
            return Err(RecordError::NotContinued { path: file.partial, what });
        }
        Ok(file)
    }

    /// Creates a partial file, or continues an existing one, whose bytes are compared with those that are written. It is changed only
    /// after its last byte.
    ///
    /// # Errors
    /// As [`Self::create`].
    pub fn create_or_continue(folder: &Path, stem: &str) -> Result<Self, RecordError> {
        let mut file = Self::open(folder, stem, 0)?;
        file.kept = file.file.metadata().map_err(|error| at(&file.partial, &error))?.len();
        Ok(file)
    }

    /// Number of existing bytes that are compared.
    #[must_use]
    pub fn kept(&self) -> u64 {
        self.kept
    }

    fn open(folder: &Path, stem: &str, kept: u64) -> Result<Self, RecordError> {
        let partial = partial_path(folder, stem);
        Ok(Self {
            file: locked(&partial)?,
            partial,
            destination: final_path(folder, stem),
            position: 0,
            kept,
            compared: Vec::new(),
            unsynced: 0,
        })
    }

    /// A second handle to sync the file while a recorder owns this one.
    ///
    /// # Errors
    /// An operating system without free handles.
    pub fn syncer(&self) -> Result<Syncer, RecordError> {
        let file = self.file.try_clone().map_err(|error| at(&self.partial, &error))?;
        Ok(Syncer { file, path: self.partial.clone() })
    }

    /// The partial name.
    #[must_use]
    pub fn partial_path(&self) -> &Path {
        &self.partial
    }

    /// The final name.
    #[must_use]
    pub fn final_path(&self) -> &Path {
        &self.destination
    }

    /// Syncs the file and keeps its partial name, after an interruption.
    ///
    /// # Errors
    /// A disk that fails.
    pub fn keep_partial(self) -> Result<PathBuf, RecordError> {
        self.sync()?;
        Ok(self.partial)
    }

    /// Syncs the file and renames it to its final name, if that is free, holds the same bytes or is that of a damaged recording.
    ///
    /// # Errors
    /// A disk that fails, a partial file that had more bytes, or other bytes under the final name; the partial file then stays.
    pub fn commit(self) -> Result<Committed, RecordError> {
        if self.position < self.kept {
            let what =
                format!("it has {} bytes more than the recording", self.kept - self.position);
            return Err(RecordError::NotContinued { path: self.partial, what });
        }
        self.sync()?;
        let committed = match take_name(&self.partial, &self.destination) {
            Ok(()) => Committed::New,
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                if same_bytes(&self.partial, &self.destination)? {
                    fs::remove_file(&self.partial).map_err(|error| at(&self.partial, &error))?;
                    Committed::AlreadyThere
                } else if is_damaged(&self.destination) && self.replaces_damaged() {
                    Committed::Replaced
                } else {
                    return Err(RecordError::Differs {
                        existing: self.destination.clone(),
                        partial: self.partial.clone(),
                    });
                }
            }
            Err(error) => return Err(at(&self.destination, &error)),
        };
        sync_folder(&self.destination)?;
        Ok(committed)
    }

    /// Gives the recording the name of a damaged one, of which the last is kept under another name. `false` if a file cannot be renamed.
    fn replaces_damaged(&self) -> bool {
        let mut kept = self.destination.clone().into_os_string();
        kept.push(".damaged");
        fs::rename(&self.destination, &kept).is_ok()
            && take_name(&self.partial, &self.destination).is_ok()
    }

    fn sync(&self) -> Result<(), RecordError> {
        self.file.sync_all().map_err(|error| at(&self.partial, &error))
    }

    /// Appends bytes and returns their number.
    fn append(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.position += count as u64;
        self.unsynced += count as u64;
        if self.unsynced >= SYNCED_EVERY {
            self.unsynced = 0;
            self.file.sync_data()?;
        }
        Ok(count)
    }

    /// Compares bytes with the existing ones and returns their number.
    fn compare(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let left = self.kept - self.position;
        let count = left.min(bytes.len() as u64).min(COMPARED_AT_ONCE) as usize;
        self.compared.resize(count, 0);
        self.file.read_exact(&mut self.compared)?;
        if self.compared != bytes[..count] {
            let what = format!("the bytes from {} on are not those of this run", self.position);
            return Err(io::Error::new(io::ErrorKind::InvalidData, what));
        }
        self.position += count as u64;
        if self.position == self.kept {
            self.file.set_len(self.kept)?;
        }
        Ok(count)
    }
}

impl Write for RecordingFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written =
            if self.position < self.kept { self.compare(bytes) } else { self.append(bytes) };
        written.map_err(|error| named(&self.partial, &error))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush().map_err(|error| named(&self.partial, &error))
    }
}

/// Syncs the file of a recording.
pub struct Syncer {
    file: File,
    path: PathBuf,
}

impl Syncer {
    /// Returns when all bytes written so far are on the disk.
    ///
    /// # Errors
    /// A disk that fails.
    pub fn sync(&self) -> Result<(), RecordError> {
        self.file.sync_data().map_err(|error| at(&self.path, &error))
    }
}

/// Path of an unfinished recording.
#[must_use]
pub fn partial_path(folder: &Path, stem: &str) -> PathBuf {
    folder.join(format!("{stem}.partial.mcap"))
}

/// Path of a finished recording.
#[must_use]
pub fn final_path(folder: &Path, stem: &str) -> PathBuf {
    folder.join(format!("{stem}.mcap"))
}

/// Opens and locks the partial file and checks that it still has this name: between opening and locking, another process may have
/// renamed it to a finished recording. A file with further names, such as that of a finished recording after a kill between the
/// two steps of [`take_name`], loses this name and keeps its bytes.
pub(crate) fn locked(partial: &Path) -> Result<File, RecordError> {
    for _ in 0..LOCK_TRIALS {
        let Some(file) = regular_file::open_as_only_writer(partial).map_err(|e| at(partial, &e))?
        else {
            // Possibly by [`is_being_written`].
            sleep(BETWEEN_TRIALS);
            continue;
        };
        if !is_still_named(&file, partial) {
            continue;
        }
        if !has_further_names(&file) {
            return Ok(file);
        }
        fs::remove_file(partial).map_err(|error| at(partial, &error))?;
    }
    Err(RecordError::Locked { path: partial.to_owned() })
}

/// Whether another process is writing a recording. Its lock is tried for an instant, which a writer that starts then waits for.
#[must_use]
pub fn is_being_written(path: &Path) -> bool {
    regular_file::has_writer(path)
}

#[cfg(unix)]
fn is_still_named(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(opened), Ok(named)) => opened.dev() == named.dev() && opened.ino() == named.ino(),
        _ => false,
    }
}

#[cfg(not(unix))]
fn is_still_named(_file: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(unix)]
fn has_further_names(file: &File) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    file.metadata().is_ok_and(|metadata| metadata.nlink() > 1)
}

#[cfg(not(unix))]
fn has_further_names(_file: &File) -> bool {
    false
}

/// Whether a recording of this program is cut off, or its bytes are not those that were written.
fn is_damaged(recording: &Path) -> bool {
    let frames = Recording::open(recording).and_then(|opened| opened.frames());
    let error = frames.map_or_else(Some, |mut frames| frames.find_map(Result::err));
    error.is_some_and(|error| {
        matches!(error.fault, ReadFault::Torn { .. } | ReadFault::Damaged { .. })
    })
}

/// Renames the file if the final name is free. Without hard links, the name is checked before the rename.
fn take_name(partial: &Path, destination: &Path) -> io::Result<()> {
    match fs::hard_link(partial, destination) {
        Ok(()) => fs::remove_file(partial),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
        Err(_) if destination.exists() => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => fs::rename(partial, destination),
    }
}

/// Whether two files hold the same bytes.
///
/// # Errors
/// A file that cannot be read.
pub fn same_bytes(left: &Path, right: &Path) -> Result<bool, RecordError> {
    let open = |path: &Path| regular_file::open(path).map_err(|error| at(path, &error));
    let ((mut left_file, left_metadata), (mut right_file, right_metadata)) =
        (open(left)?, open(right)?);
    if left_metadata.len() != right_metadata.len() {
        return Ok(false);
    }
    let (mut left_part, mut right_part) = (Vec::new(), Vec::new());
    loop {
        read_part(&mut left_file, &mut left_part).map_err(|error| at(left, &error))?;
        read_part(&mut right_file, &mut right_part).map_err(|error| at(right, &error))?;
        if left_part != right_part {
            return Ok(false);
        }
        if left_part.is_empty() {
            return Ok(true);
        }
    }
}

/// The next part of a file; empty at its end.
fn read_part(file: &mut File, part: &mut Vec<u8>) -> io::Result<()> {
    part.clear();
    file.take(COMPARED_AT_ONCE).read_to_end(part).map(|_| ())
}

fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", shown_path(path)))
}

pub(crate) fn at(path: &Path, error: &io::Error) -> RecordError {
    RecordError::Io(named(path, error))
}
