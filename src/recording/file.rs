//! A recording's file: it grows under a partial name and takes its final name only when it is whole.

use crate::error::RecordError;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// Tries to take a file that another process may be renaming under our hands.
const LOCK_TRIALS: u32 = 8;
/// Bytes after which the disk is asked to catch up: what is left for the run's end to wait for is short.
const SYNCED_EVERY: u64 = 16 << 20;
/// Bytes of two files that are compared at once.
const COMPARED_AT_ONCE: u64 = 1 << 20;

/// `STEM.partial.mcap` while it is written; `STEM.mcap` after [`RecordingFile::commit`].
///
/// The file is locked while this value lives, so that two processes never write the same recording.
pub struct RecordingFile {
    file: File,
    partial: PathBuf,
    destination: PathBuf,
    /// Where the next byte belongs.
    position: u64,
    /// Bytes that were there before: what is written up to here is compared with them, and only then the file grows.
    kept: u64,
    compared: Vec<u8>,
    /// Bytes written since the disk was last asked to catch up.
    unsynced: u64,
}

/// Whether the final name was free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Committed {
    /// It was, and is now taken.
    New,
    /// A recording with the same bytes was there.
    AlreadyThere,
}

impl RecordingFile {
    /// Starts an empty partial file; what an earlier try left under its name is cut off.
    ///
    /// # Errors
    /// A folder that can't be written, or another process at the same recording.
    pub fn create(folder: &Path, stem: &str) -> Result<Self, RecordError> {
        let file = Self::open(folder, stem, 0)?;
        file.file.set_len(0).map_err(|error| at(&file.partial, &error))?;
        Ok(file)
    }

    /// Goes on with a partial file after its first `kept` bytes. These must be written once more: they are compared with
    /// what is there, and what follows them is cut off when they have passed.
    ///
    /// # Errors
    /// A file that is shorter or can't be opened, or another process at the same recording.
    pub fn reopen(folder: &Path, stem: &str, kept: u64) -> Result<Self, RecordError> {
        let file = Self::open(folder, stem, kept)?;
        let length = file.file.metadata().map_err(|error| at(&file.partial, &error))?.len();
        if length < kept {
            let what = format!("it has {length} bytes, the checkpoint counts on {kept}");
            return Err(RecordError::NotContinued { path: file.partial, what });
        }
        Ok(file)
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

    /// A second handle, through which the file's bytes so far are brought to the disk while a recorder owns this one.
    ///
    /// # Errors
    /// An operating system that has no handle left.
    pub fn syncer(&self) -> Result<Syncer, RecordError> {
        let file = self.file.try_clone().map_err(|error| at(&self.partial, &error))?;
        Ok(Syncer { file, path: self.partial.clone() })
    }

    /// The name while it is written.
    #[must_use]
    pub fn partial_path(&self) -> &Path {
        &self.partial
    }

    /// The name that it takes in the end.
    #[must_use]
    pub fn final_path(&self) -> &Path {
        &self.destination
    }

    /// Brings all bytes to the disk; the file stays under its partial name (an orderly stop).
    ///
    /// # Errors
    /// A disk that fails.
    pub fn keep_partial(self) -> Result<PathBuf, RecordError> {
        self.sync()?;
        Ok(self.partial)
    }

    /// Brings all bytes to the disk and takes the final name, if that is free or holds the same bytes.
    ///
    /// # Errors
    /// A disk that fails, or other bytes under the final name; the partial file then stays.
    pub fn commit(self) -> Result<Committed, RecordError> {
        self.sync()?;
        let committed = match take_name(&self.partial, &self.destination) {
            Ok(()) => Committed::New,
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                if !same_bytes(&self.partial, &self.destination)? {
                    return Err(RecordError::Differs {
                        existing: self.destination.clone(),
                        partial: self.partial.clone(),
                    });
                }
                fs::remove_file(&self.partial).map_err(|error| at(&self.partial, &error))?;
                Committed::AlreadyThere
            }
            Err(error) => return Err(at(&self.destination, &error)),
        };
        sync_folder(&self.destination)?;
        Ok(committed)
    }

    fn sync(&self) -> Result<(), RecordError> {
        self.file.sync_all().map_err(|error| at(&self.partial, &error))
    }

    /// Appends bytes; how many of them were taken.
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

    /// Compares bytes with those that are there; how many of them were compared.
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

/// Brings a recording's bytes to the disk.
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

/// Name of a recording that is not finished.
#[must_use]
pub fn partial_path(folder: &Path, stem: &str) -> PathBuf {
    folder.join(format!("{stem}.partial.mcap"))
}

/// Removes what an earlier try left beside a finished recording: a partial file that nobody writes, and its checkpoint.
///
/// # Errors
/// A folder that can't be written.
pub fn remove_leftovers(folder: &Path, stem: &str) -> Result<(), RecordError> {
    crate::checkpoint::remove(folder, stem)?;
    let partial = partial_path(folder, stem);
    if !partial.exists() {
        return Ok(());
    }
    match locked(&partial) {
        Ok(_locked) => fs::remove_file(&partial).map_err(|error| at(&partial, &error)),
        Err(RecordError::Locked { .. }) => Ok(()),
        Err(error) => Err(error),
    }
}

/// Name of a finished recording.
#[must_use]
pub fn final_path(folder: &Path, stem: &str) -> PathBuf {
    folder.join(format!("{stem}.mcap"))
}

/// Opens and locks the partial file, and makes sure that it is still the one of that name: a process that committed
/// between our opening and our lock has turned it into a finished recording.
fn locked(partial: &Path) -> Result<File, RecordError> {
    for _ in 0..LOCK_TRIALS {
        let file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(partial)
            .map_err(|error| at(partial, &error))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(RecordError::Locked { path: partial.to_owned() });
            }
            Err(TryLockError::Error(error)) => return Err(at(partial, &error)),
        }
        if is_still_named(&file, partial) {
            return Ok(file);
        }
    }
    Err(RecordError::Locked { path: partial.to_owned() })
}

#[cfg(unix)]
fn is_still_named(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    match (file.metadata(), fs::metadata(path)) {
        (Ok(opened), Ok(named)) => opened.dev() == named.dev() && opened.ino() == named.ino(),
        _ => false,
    }
}

#[cfg(not(unix))]
fn is_still_named(_file: &File, path: &Path) -> bool {
    path.exists()
}

/// Gives the file its final name only if that is free. File systems without hard links get a check and a rename.
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
/// A file that can't be read.
pub fn same_bytes(left: &Path, right: &Path) -> Result<bool, RecordError> {
    let open = |path: &Path| File::open(path).map_err(|error| at(path, &error));
    let (mut left_file, mut right_file) = (open(left)?, open(right)?);
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

/// Makes the new name last. Only Unix opens folders.
pub(crate) fn sync_folder(path: &Path) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if cfg!(unix) && !folder.as_os_str().is_empty() => folder,
        Some(_) if cfg!(unix) => Path::new("."),
        _ => return Ok(()),
    };
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(|error| named(folder, &error))
}

fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

pub(crate) fn at(path: &Path, error: &io::Error) -> RecordError {
    RecordError::Io(named(path, error))
}
