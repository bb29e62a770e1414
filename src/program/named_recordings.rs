//! The recordings that a command line names: files, and those in folders.

use crate::messages::Failure;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use std::fs;
use std::path::{Path, PathBuf};

/// The paths in their order; a folder stands for the recordings in it and in its subfolders, by name.
///
/// # Errors
/// A folder without recordings, or one that cannot be listed.
pub(crate) fn named_recordings(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut named = Vec::new();
    for path in paths {
        if !path.is_dir() {
            named.push(path.clone());
            continue;
        }
        let before = named.len();
        add_below(path, &mut named)?;
        if named.len() == before {
            let what = format!("{} is a folder with 0 recordings", shown_path(path));
            let failure = Failure::new(Exit::Unreadable, what);
            let has_table = path.join("runs.parquet").is_file();
            return Err(failure.help(match has_table {
                true => "its runs are rows of runs.parquet: `verify --sample 100` executes some again, and `restore` writes recordings",
                false => "name a recording (*.mcap), or a folder of recordings",
            }));
        }
    }
    Ok(named)
}

fn add_below(folder: &Path, named: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let listed = fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| entry.map(|entry| entry.path())).collect());
    let mut paths: Vec<PathBuf> = listed.map_err(|error| {
        let what = format!("{} cannot be listed: {error}", shown_path(folder));
        Failure::new(Exit::Unreadable, what).help("check its permissions")
    })?;
    paths.sort();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() && !path.is_symlink() {
            add_below(&path, named)?;
        } else if name.ends_with(".mcap") && !name.ends_with(".partial.mcap") {
            named.push(path);
        }
    }
    Ok(())
}
