//! The folder of a file.

use kinetoscope_console::text::shown_path;
use std::fs::File;
use std::io;
use std::path::Path;

/// The folder in which a file is. A bare name such as `run.mcap` is in the folder `.`, which [`Path::parent`] calls an empty path.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        Some(_) | None => Path::new("."),
    }
}

/// Syncs the folder of a renamed file; only on Unix, where a folder can be opened.
///
/// # Errors
/// A disk that fails.
pub fn sync_folder(path: &Path) -> io::Result<()> {
    if !cfg!(unix) || path.parent().is_none() {
        return Ok(());
    }
    let folder = folder_of(path);
    let named =
        |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", shown_path(folder)));
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(named)
}

#[cfg(test)]
mod tests {
    use super::folder_of;
    use std::path::Path;

    #[test]
    fn bare_name_is_in_the_current_folder() {
        for (path, folder) in [
            ("run.mcap", "."),
            ("./run.mcap", "."),
            ("a/run.mcap", "a"),
            ("/run.mcap", "/"),
            ("/a/b/run.mcap", "/a/b"),
            ("", "."),
        ] {
            assert_eq!(folder_of(Path::new(path)), Path::new(folder), "{path}");
        }
    }
}
