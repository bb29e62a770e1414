//! Stale files: recordings of another seed, other values or another version of the physics than the manifest's, partial files of
//! such runs, plots that show them, and temporary files of killed processes.

use crate::plan::{Plan, PlannedRun};
use kinetoscope_files::atomic_file::{leftovers, remove_if_exists};
use kinetoscope_files::folder::folder_of;
use kinetoscope_recording::plot_list::{CACHE_FOLDER, listed_plots, listed_recordings};
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::removal::{Removal, remove_leftovers, remove_recording};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Extensions of the side files of a recording, in addition to those of an unfinished run.
const SIDE_FILES: [&str; 2] = ["host.json", "failed.txt"];

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
    /// Temporary files of killed processes, here and in the cache of the analysis.
    temporaries: Vec<PathBuf>,
}

impl StaleFiles {
    /// Finds the stale files. Files of other programs are skipped.
    ///
    /// # Errors
    /// A folder that exists and cannot be read.
    pub fn of(plan: &Plan) -> io::Result<Self> {
        let mut wanted: BTreeSet<String> = plan.runs.iter().map(|run| run.file_name()).collect();
        wanted.extend(plan.runs.iter().filter_map(PlannedRun::restored_file_name));
        let entries = match fs::read_dir(&plan.folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(error),
        };
        let experiment = plan.folder.file_name().and_then(OsStr::to_str).unwrap_or_default();
        let caches = leftovers(&plan.folder.join(CACHE_FOLDER));
        let temporaries = [leftovers(&plan.folder), caches].concat();
        let mut stale = Self { temporaries, ..Self::default() };
        for entry in entries {
            let path = entry?.path();
            let Some(name) = path.file_name().and_then(OsStr::to_str) else { continue };
            if let Some(stem) = name.strip_suffix(PARTIAL) {
                if !wanted.contains(&format!("{stem}.mcap")) && key_in(stem, experiment).is_some() {
                    stale.partials.push(path);
                }
            } else if !wanted.contains(name) && is_recording_of(name, experiment, &path) {
                stale.recordings.push(path);
            }
        }
        let is_shown = |path: &PathBuf| {
            let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
            listed_recordings(&plan.folder).iter().any(|shown| shown == name)
        };
        if stale.recordings.iter().chain(&stale.partials).any(is_shown) {
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
        let all = [&self.recordings, &self.partials, &self.plots, &self.temporaries];
        all.into_iter().flatten().map(PathBuf::as_path)
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
    let folder = folder_of(path);
    if let Some(stem) = name.strip_suffix(PARTIAL) {
        return remove_leftovers(folder, stem).map_err(io::Error::other);
    }
    match name.strip_suffix(".mcap") {
        Some(stem) => remove_recording(folder, stem, &SIDE_FILES).map_err(io::Error::other),
        None => remove_if_exists(path).map(|()| Removal::Removed),
    }
}

/// The start of a run key at the end of a stem, if it begins with the name of an experiment as those of its runs do.
fn key_in<'a>(stem: &'a str, experiment: &str) -> Option<&'a str> {
    let rest = stem.strip_prefix(experiment).filter(|rest| rest.starts_with("__"))?;
    let (_, key) = rest.rsplit_once("__")?;
    let is_key = key.len() >= 8 && key.chars().all(|digit| digit.is_ascii_hexdigit());
    is_key.then_some(key)
}

/// Whether a file is a recording of an experiment whose name ends in the start of its run key.
fn is_recording_of(name: &str, experiment: &str, path: &Path) -> bool {
    let key = name.strip_suffix(".mcap").and_then(|stem| key_in(stem, experiment));
    key.is_some_and(|key| {
        Recording::open(path).is_ok_and(|recording| recording.provenance().run_key.starts_with(key))
    })
}

#[cfg(test)]
mod tests {
    use super::StaleFiles;
    use std::path::PathBuf;

    #[test]
    fn files_that_another_process_removed_count_as_removed() {
        let folder = std::env::temp_dir().join(format!("pruned-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let gone = |name: &str| vec![folder.join(name)];
        let stale = StaleFiles {
            recordings: gone("gas__01234567.mcap"),
            partials: gone("gas__89abcdef.partial.mcap"),
            plots: gone("energy.svg"),
            temporaries: gone(".kinetoscope-a.tmp"),
        };
        let mut removed: Vec<PathBuf> = Vec::new();
        stale.remove(&mut |path, _| removed.push(path.to_owned())).unwrap();
        assert_eq!(removed.len(), 4);
        // The files of the locks are removed as well.
        std::fs::remove_dir(&folder).unwrap();
    }
}
