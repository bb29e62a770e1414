//! Stale recordings: those of another seed, other values or another version of the physics than the manifest's.

use crate::plan::Plan;
use kinetoscope_recording::reader::Recording;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Extensions of the side files of a recording.
const SIDE_FILES: [&str; 5] =
    ["host.json", "verified.json", "checkpoint", "partial.mcap", "failed.txt"];

/// The recordings in the plan's folder that belong to no run of the plan, sorted. Files of other programs are skipped.
///
/// # Errors
/// A folder that exists and cannot be read.
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
        if !wanted.contains(name) && has_its_key(name, &path) {
            stale.push(path);
        }
    }
    stale.sort();
    Ok(stale)
}

/// Removes recordings and their side files.
///
/// # Errors
/// A folder that cannot be written.
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
fn has_its_key(name: &str, path: &Path) -> bool {
    let key =
        name.strip_suffix(".mcap").and_then(|stem| stem.rsplit_once("__")).map(|(_, key)| key);
    key.is_some_and(|key| {
        Recording::open(path).is_ok_and(|recording| recording.provenance().run_key.starts_with(key))
    })
}
