//! Whole files, written next to their place and then moved there.

use std::io;
use std::path::{Path, PathBuf};

/// A file or folder that can't be written.
#[derive(Debug)]
pub struct WriteError {
    path: PathBuf,
    why: String,
}

impl WriteError {
    pub(crate) fn new(path: PathBuf, why: String) -> Self {
        Self { path, why }
    }
}

impl std::fmt::Display for WriteError {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let path = self.path.display();
        write!(
            formatter,
            "{path} can't be written: {}. Make room or make it writable, or name another folder with --output DIR",
            self.why
        )
    }
}

/// Makes a folder with all above it.
///
/// # Errors
/// A folder that can't be made.
pub fn create_folder(folder: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(folder)
        .map_err(|error| WriteError { path: folder.to_path_buf(), why: error.to_string() })
}

/// Writes a file beside its place and then puts it there: nobody sees half of it.
///
/// # Errors
/// A file that can't be written.
pub fn replace(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".new");
    let temporary = path.with_file_name(name);
    let write = || -> io::Result<()> {
        std::fs::write(&temporary, content)?;
        std::fs::rename(&temporary, path)
    };
    write().map_err(|error| WriteError { path: path.to_path_buf(), why: error.to_string() })
}
