//! Recordings that a manifest no longer asks for: of another seed, other values or another version of the physics.

use crate::plan::Plan;
use kinetoscope_recording::reader::Recording;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What stands beside a recording, by the end of its name.
const SIDE_FILES: [&str; 5] =
    ["host.json", "verified.json", "checkpoint", "partial.mcap", "failed.txt"];

/// The recordings in the plan's folder that no run of the plan makes, sorted. A file that is no recording of ours is none.
///
/// # Errors
/// A folder that is there and can't be read.
pub fn stale(plan: &Plan) -> io::Result<Vec<PathBuf>> {
    let wanted: BTreeSet<String> = plan.runs.iter().map(|run| run.file_name()).collect();
    let entries = match fs::read_dir(&plan.folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(error),
    };
    let mut stale = Vec::new();
    for entry in entries {
        let path = entry?.path();
        let Some(name) = path.file_name().and_then(OsStr::to_str) else { continue };
        if !wanted.contains(name) && carries_its_key(name, &path) {
            stale.push(path);
        }
    }
    stale.sort();
    Ok(stale)
}

/// Removes recordings with what stands beside them.
///
/// # Errors
/// A folder that can't be written.
pub fn remove(recordings: &[PathBuf]) -> io::Result<()> {
    for recording in recordings {
        fs::remove_file(recording)?;
        for end in SIDE_FILES {
            match fs::remove_file(recording.with_extension(end)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                Ok(()) | Err(_) => {}
            }
        }
    }
    Ok(())
}

/// Whether a file is a recording whose name ends in the start of its run key.
fn carries_its_key(name: &str, path: &Path) -> bool {
    let key =
        name.strip_suffix(".mcap").and_then(|stem| stem.rsplit_once("__")).map(|(_, key)| key);
    key.is_some_and(|key| {
        Recording::open(path).is_ok_and(|recording| recording.provenance().run_key.starts_with(key))
    })
}
