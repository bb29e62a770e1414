//! Storage of recordings: folders, or any other source of bytes with random access.

use kinetoscope_files::regular_file;
use std::fmt;
use std::io::{self, Cursor, Read, Seek};
use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

/// An input with random access.
pub trait Input: Read + Seek + Send {}

impl<T: Read + Seek + Send> Input for T {}

/// A file, opened.
pub struct Opened {
    /// Its bytes, from the first one.
    pub input: Box<dyn Input>,
    /// Number of bytes.
    pub bytes: u64,
    /// Time of the last change, if known.
    pub changed: Option<SystemTime>,
}

/// A storage of recordings.
pub trait Storage: fmt::Debug + Send + Sync {
    /// Opens a file.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] if the file does not exist, or another error of the storage.
    fn open(&self, path: &Path) -> io::Result<Opened>;
}

/// The folders of this machine.
#[derive(Clone, Copy, Debug)]
pub struct LocalFolders;

impl Storage for LocalFolders {
    fn open(&self, path: &Path) -> io::Result<Opened> {
        let (file, metadata) = regular_file::open(path)?;
        let changed = metadata.modified().ok();
        Ok(Opened { input: Box::new(file), bytes: metadata.len(), changed })
    }
}

/// The bytes of one recording in memory, under any path.
#[derive(Clone)]
pub(crate) struct InMemory(pub(crate) Arc<[u8]>);

impl fmt::Debug for InMemory {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "InMemory({} bytes)", self.0.len())
    }
}

impl Storage for InMemory {
    fn open(&self, _: &Path) -> io::Result<Opened> {
        let bytes = self.0.len() as u64;
        Ok(Opened { input: Box::new(Cursor::new(Arc::clone(&self.0))), bytes, changed: None })
    }
}
