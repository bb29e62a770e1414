//! Where recordings lie: in folders, or anywhere else that gives bytes from any place on.

use std::fmt;
use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;
use std::time::SystemTime;

/// Bytes that are read from any place on.
pub trait Input: Read + Seek + Send {}

impl<T: Read + Seek + Send> Input for T {}

/// A file, opened.
pub struct Opened {
    /// Its bytes, from the first one on.
    pub input: Box<dyn Input>,
    /// How many there are.
    pub bytes: u64,
    /// When it was last changed, where that is known.
    pub changed: Option<SystemTime>,
}

/// Where recordings lie.
pub trait Storage: fmt::Debug + Send + Sync {
    /// Opens a file.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] where it is not there, else why it can't be read.
    fn open(&self, path: &Path) -> io::Result<Opened>;
}

/// The folders of this machine.
#[derive(Clone, Copy, Debug)]
pub struct LocalFolders;

impl Storage for LocalFolders {
    fn open(&self, path: &Path) -> io::Result<Opened> {
        let file = File::open(path)?;
        let metadata = file.metadata()?;
        let changed = metadata.modified().ok();
        Ok(Opened { input: Box::new(file), bytes: metadata.len(), changed })
    }
}
