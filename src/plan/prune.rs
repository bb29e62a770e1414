//! Stale files: recordings of another seed, other values or another version of the physics than the manifest's, partial files of
//! such runs, and plots that show them.

use crate::plan::Plan;
use kinetoscope_recording::atomic_file::remove_if_exists;
use kinetoscope_recording::plot_list::listed_plots;
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::removal::{Removal, remove_leftovers, remove_recording};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Extensions of the side files of a recording, in addition to those of an unfinished run.
const SIDE_FILES: [&str; 3] = ["host.json", "verified.json", "failed.txt"];

/// The ending of a recording that is being written.
const PARTIAL: &str = ".partial.mcap";

/// The stale files in a plan's folder, each kind sorted.
#[derive(Debug, Default)]
pub struct StaleFiles {
    /// Recordings that belong to no run of the plan.
    recordings: Vec<PathBuf>,
    /// Partial files of unfinished runs that the plan no longer has.
    partials: Vec<PathBuf>,
    /// Plots of an analysis that read some of these files; the next analysis draws its own.
    plots: Vec<PathBuf>,
}

impl StaleFiles {
    /// Finds the stale files. Files of other programs are skipped.
    ///
    /// # Errors
    /// A folder that exists and cannot be read.
    pub fn of(plan: &Plan) -> io::Result<Self> {
        let wanted: BTreeSet<String> = plan.runs.iter().map(|run| run.file_name()).collect();
        let entries = match fs::read_dir(&plan.folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(error),
        };
        let experiment = plan.folder.file_name().and_then(OsStr::to_str).unwrap_or_default();
        let mut stale = Self::default();
        for entry in entries {
            let path = entry?.path();
            let Some(name) = path.file_name().and_then(OsStr::to_str) else { continue };
            if let Some(stem) = name.strip_suffix(PARTIAL) {
                if !wanted.contains(&format!("{stem}.mcap")) && is_stem_of(stem, experiment) {
                    stale.partials.push(path);
                }
            } else if !wanted.contains(name) && has_its_key(name, &path) {
                stale.recordings.push(path);
            }
        }
        if !stale.recordings.is_empty() || !stale.partials.is_empty() {
            let plots = listed_plots(&plan.folder).into_iter();
            stale.plots = plots.map(|name| plan.folder.join(name)).collect();
            stale.plots.retain(|plot| plot.is_file());
        }
        for files in [&mut stale.recordings, &mut stale.partials, &mut stale.plots] {
            files.sort();
        }
        Ok(stale)
    }

    /// All stale files.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        [&self.recordings, &self.partials, &self.plots].into_iter().flatten().map(PathBuf::as_path)
    }

    /// Removes the files, and the side files of the recordings, except for those of runs that another process is writing.
    /// `report` receives each file and whether it was removed. A file that another process removes meanwhile counts as removed.
    ///
    /// # Errors
    /// The first file that cannot be removed, after the others were removed.
    pub fn remove(&self, report: &mut dyn FnMut(&Path, Removal)) -> io::Result<()> {
        let mut first_error = Ok(());
        for path in self.paths() {
            match removed(path) {
                Ok(removal) => report(path, removal),
                Err(error) => first_error = first_error.and(Err(error)),
            }
        }
        first_error
    }
}

/// Removes a stale file.
fn removed(path: &Path) -> io::Result<Removal> {
    let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
    let folder = path.parent().unwrap_or(Path::new(""));
    if let Some(stem) = name.strip_suffix(PARTIAL) {
        return remove_leftovers(folder, stem).map_err(io::Error::other);
    }
    match name.strip_suffix(".mcap") {
        Some(stem) => remove_recording(folder, stem, &SIDE_FILES).map_err(io::Error::other),
        None => remove_if_exists(path).map(|()| Removal::Removed),
    }
}

/// Whether a stem is that of a run of an experiment: its name, and the start of a run key at the end.
fn is_stem_of(stem: &str, experiment: &str) -> bool {
    let rest = stem.strip_prefix(experiment).filter(|rest| rest.starts_with("__"));
    let key = rest.and_then(|rest| rest.rsplit_once("__")).map(|(_, key)| key);
    key.is_some_and(|key| key.len() >= 8 && key.chars().all(|digit| digit.is_ascii_hexdigit()))
}

/// Whether a file is a recording whose name ends in the start of its run key.
fn has_its_key(name: &str, path: &Path) -> bool {
    let key =
        name.strip_suffix(".mcap").and_then(|stem| stem.rsplit_once("__")).map(|(_, key)| key);
    key.is_some_and(|key| {
        Recording::open(path).is_ok_and(|recording| recording.provenance().run_key.starts_with(key))
    })
}
