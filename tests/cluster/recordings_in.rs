//! The recordings of a folder, for tests that compare folders.
#![allow(clippy::unwrap_used, reason = "a test's helper may panic")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Names and bytes of all recordings in a folder.
pub(crate) fn recordings_in(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .filter(|path| path.extension().is_some_and(|extension| extension == "mcap"))
        .map(|path| {
            (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap())
        })
        .collect()
}
