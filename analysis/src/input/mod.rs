//! Finds the recordings behind paths and groups them by folder and experiment.

pub(crate) mod coordinates;
mod error;
pub(crate) mod host_file;
pub(crate) mod key_words;
mod object_storage;
pub mod recording;

pub use error::UnreadableRecording;
pub(crate) use error::{InvalidPath, ON_FAILED_DISK};

use crate::input::recording::{OpenRun, is_partial, restored_file};
use kinetoscope_console::text::{every, plural, shown_path};
use kinetoscope_files::folder::folder_of;
use kinetoscope_files::regular_file::{MAX_EXPERIMENT_RECORD_BYTES, read_opened};
use kinetoscope_manifest::{Coordinate, ExperimentRecord};
use kinetoscope_object_storage::address::Address;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{Recording, StoredFrames};
use kinetoscope_recording::storage::{LocalFolders, Opened, Storage};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Name of the file next to the recordings that describes the experiment.
pub(crate) const SIDE_CAR: &str = "experiment.toml";
/// Name of the file with one row per run.
pub(crate) const RUNS_TABLE: &str = "runs.parquet";

/// Recordings that are analyzed together: those of one folder.
#[derive(Debug)]
pub(crate) struct RecordingFolder {
    /// The storage that contains the folder.
    storage: Arc<dyn Storage>,
    /// The folder or its address.
    pub(crate) folder: PathBuf,
    /// Name of the experiment, from `experiment.toml` or else from the folder.
    pub(crate) name: String,
    /// The record of the experiment, if the folder contains one for these recordings.
    pub(crate) record: Option<ExperimentRecord>,
    /// Index of the record's run per file name.
    index: BTreeMap<String, usize>,
    /// Names of recordings that `kinetoscope fill` restored, which take the place of those of their keyframes.
    restored: BTreeSet<String>,
    /// The recordings, sorted.
    pub(crate) files: Vec<PathBuf>,
    /// Whether the folder has no recordings, but a table of its runs.
    pub(crate) is_table: bool,
    /// Whether the whole folder was given rather than some of its files.
    pub(crate) whole: bool,
    /// Notes for the user.
    pub(crate) notes: Vec<String>,
    /// What could not be read, with reasons.
    pub(crate) unreadable: Vec<UnreadableRecording>,
}

/// The open recordings of a folder.
pub(crate) struct OpenedRuns {
    /// The runs with their coordinates in the sweep, in the order of the experiment.
    pub(crate) runs: Vec<(OpenRun, Vec<Coordinate>)>,
    /// Notes for the user.
    notes: Vec<String>,
    /// What could not be read, with reasons.
    pub(crate) unreadable: Vec<UnreadableRecording>,
}

/// Finds the recordings behind paths and addresses (`s3://BUCKET/PREFIX`): one entry per folder, in the order of the
/// paths.
///
/// # Errors
/// The first path without recordings.
pub(crate) fn sources(paths: &[PathBuf]) -> Result<Vec<RecordingFolder>, InvalidPath> {
    found_sources(paths, false)
}

/// As [`sources`], with the folders of experiments that have no recordings, but a table of their runs.
///
/// # Errors
/// The first path without either.
pub(crate) fn sources_and_tables(paths: &[PathBuf]) -> Result<Vec<RecordingFolder>, InvalidPath> {
    found_sources(paths, cfg!(feature = "parquet"))
}

fn found_sources(
    paths: &[PathBuf],
    with_tables: bool,
) -> Result<Vec<RecordingFolder>, InvalidPath> {
    let mut found: Vec<RecordingFolder> = Vec::new();
    let mut named: BTreeMap<PathBuf, Vec<PathBuf>> = BTreeMap::new();
    for path in paths {
        let is_remote = Address::is_one(path);
        let before = found.len();
        if is_remote && !file_name(path).ends_with(".mcap") {
            search_remote(path, &mut found)?;
            if found.len() == before {
                return Err(InvalidPath::without_recordings(path));
            }
        } else if path.is_dir() {
            search(path, with_tables, &mut found);
            if found.len() == before {
                return Err(InvalidPath::without_recordings(path));
            }
        } else if is_remote || path.exists() {
            named.entry(folder_of(path).to_path_buf()).or_default().push(path.clone());
        } else {
            return Err(InvalidPath::new(
                format!("{} does not exist", shown_path(path)),
                "check the path, or run the experiment first",
            ));
        }
    }
    for (folder, mut files) in named {
        files.sort();
        files.dedup();
        if !found.iter().any(|source| source.folder == folder) {
            let storage: Arc<dyn Storage> = if Address::is_one(&folder) {
                object_storage::open(&folder)?
            } else {
                Arc::new(LocalFolders)
            };
            found.push(source(storage, folder, files, false));
        }
    }
    Ok(found)
}

/// Whether several folders contain recordings.
pub(crate) fn are_several(sources: &[RecordingFolder]) -> bool {
    sources.iter().filter(|source| !source.is_empty()).count() > 1
}

/// Adds the recordings under an address.
fn search_remote(address: &Path, found: &mut Vec<RecordingFolder>) -> Result<(), InvalidPath> {
    let store = object_storage::open(address)?;
    for (folder, files) in object_storage::folders(&store)? {
        if !found.iter().any(|source| source.folder == folder) {
            found.push(source(store.clone(), folder, files, true));
        }
    }
    Ok(())
}

/// Adds the recordings of a folder and its subfolders. A folder that cannot be listed is one whose recordings are unreadable.
fn search(folder: &Path, with_tables: bool, found: &mut Vec<RecordingFolder>) {
    let mut paths = match listed(folder) {
        Ok(paths) => paths,
        Err(error) => {
            let mut unlisted = RecordingFolder::new(
                Arc::new(LocalFolders),
                folder.to_path_buf(),
                Vec::new(),
                true,
            );
            let shown = shown_path(folder);
            unlisted.unreadable.push(UnreadableRecording::of_io(
                &error,
                format!("{shown} cannot be listed: {error}"),
                "check its permissions",
            ));
            found.push(unlisted);
            return;
        }
    };
    paths.sort();
    // A link to a file that is missing is named as unreadable.
    let is_broken_link = |path: &PathBuf| path.is_symlink() && !path.exists();
    let is_recording = |path: &&PathBuf| {
        let name = file_name(path);
        name.ends_with(".mcap") && !is_partial(&name) && (path.is_file() || is_broken_link(path))
    };
    let files: Vec<PathBuf> = paths.iter().filter(is_recording).cloned().collect();
    if !files.is_empty() && !found.iter().any(|source| source.folder == folder) {
        found.push(source(Arc::new(LocalFolders), folder.to_path_buf(), files, true));
    } else if with_tables && [RUNS_TABLE, SIDE_CAR].iter().all(|name| folder.join(name).is_file()) {
        let (storage, files) = (Arc::new(LocalFolders), Vec::new());
        let mut source = RecordingFolder::new(storage, folder.to_owned(), files, true);
        source.is_table = true;
        source.read_side_car();
        found.push(source);
    }
    for path in paths.iter().filter(|path| path.is_dir() && !path.is_symlink()) {
        search(path, with_tables, found);
    }
}

/// The paths in a folder.
fn listed(folder: &Path) -> io::Result<Vec<PathBuf>> {
    std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect()
}

fn source(
    storage: Arc<dyn Storage>,
    folder: PathBuf,
    files: Vec<PathBuf>,
    whole: bool,
) -> RecordingFolder {
    let mut source = RecordingFolder::new(storage, folder, files, whole);
    source.read_side_car();
    source
}

impl RecordingFolder {
    fn new(storage: Arc<dyn Storage>, folder: PathBuf, files: Vec<PathBuf>, whole: bool) -> Self {
        let remote = Address::is_one(&folder).then(|| folder.clone());
        let name = remote.or_else(|| std::fs::canonicalize(&folder).ok());
        let name = name.as_deref().map_or_else(|| "recordings".to_owned(), file_name);
        Self {
            storage,
            folder,
            name,
            record: None,
            index: BTreeMap::new(),
            restored: BTreeSet::new(),
            files,
            is_table: false,
            whole,
            notes: Vec::new(),
            unreadable: Vec::new(),
        }
    }

    /// Whether the folder has neither recordings nor a table of runs.
    pub(crate) fn is_empty(&self) -> bool {
        self.files.is_empty() && !self.is_table
    }

    /// Whether the folder is on object storage.
    pub(crate) fn is_remote(&self) -> bool {
        Address::is_one(&self.folder)
    }

    /// Opens one of the recordings.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub(crate) fn recording(&self, path: &Path) -> Result<Recording, ReadError> {
        Recording::open_in(Arc::clone(&self.storage), path)
    }

    /// Reads a small text file.
    fn text(&self, path: &Path) -> io::Result<String> {
        let Opened { input, bytes, .. } = self.storage.open(path)?;
        let content = read_opened(input, bytes, MAX_EXPERIMENT_RECORD_BYTES)?;
        String::from_utf8(content)
            .map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
    }

    fn read_side_car(&mut self) {
        let path = self.folder.join(SIDE_CAR);
        let text = match self.text(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return,
            Err(error) => {
                self.unreadable.push(UnreadableRecording::of_io(
                    &error,
                    format!("{}: {error}; its recordings are read without it", shown_path(&path)),
                    "run the experiment again to write it again",
                ));
                return;
            }
        };
        match ExperimentRecord::from_toml(&text, SIDE_CAR) {
            Ok(record) => self.sort_by(record),
            Err(diagnostics) => {
                let path = shown_path(&path);
                let errors = diagnostics.to_string();
                self.unreadable.push(UnreadableRecording::new(
                    format!(
                        "{path} cannot be read: its recordings are analyzed without it, and its checks are not evaluated\n{}",
                        errors.trim_end()
                    ),
                    "run the experiment again to write it again",
                ));
            }
        }
    }

    /// Removes recordings that do not belong to the latest run of the experiment.
    fn sort_by(&mut self, record: ExperimentRecord) {
        if let Some(runs) = record.unlisted_runs {
            let folder = shown_path(&self.folder);
            self.unreadable.push(UnreadableRecording::new(
                format!("{folder} has {runs} runs, more than an analysis reads"),
                format!("average them with `kinetoscope table {folder} --group KEY`; `kinetoscope restore` writes recordings of single runs to another folder with --output"),
            ));
            self.files.clear();
            self.is_table = false;
            return;
        }
        if self.is_table {
            self.name.clone_from(&record.name);
            self.record = Some(record);
            return;
        }
        let names = record.runs.iter().enumerate().map(|(at, run)| (run.file.clone(), at));
        let index: BTreeMap<String, usize> = names.collect();
        // A name that is not UTF-8 is no run's name, although it may be shown as one.
        let belongs = |path: &PathBuf| {
            let name = path.file_name().and_then(OsStr::to_str);
            name.is_some_and(|name| index.contains_key(&finished_name(name)))
        };
        let (mut files, mut stale): (Vec<_>, Vec<_>) = self.files.drain(..).partition(belongs);
        let mut index = index;
        for file in &mut files {
            self.take_restored(file, &mut stale, &mut index);
        }
        if files.is_empty() || !self.whole && !stale.is_empty() {
            // Files that were given individually are read, but not as parts of this experiment.
            self.files = files.into_iter().chain(stale).collect();
            self.files.sort();
            self.notes.push(format!(
                "not all of these recordings belong to the experiment as run last ({SIDE_CAR}): they are compared by their manifests alone"
            ));
            return;
        }
        for path in &stale {
            match self.recording(path) {
                Ok(recording) if is_part(&recording) => self.notes.push(part_note(path)),
                Ok(_) => self.notes.push(format!(
                    "{} is stale: the experiment as run last has no such run; left out",
                    file_name(path)
                )),
                Err(error) => self.unreadable.push(error.into()),
            }
        }
        self.files = files;
        self.name.clone_from(&record.name);
        if self.whole {
            let missing = record.runs.len().saturating_sub(self.files.len());
            if missing > 0 {
                self.notes.push(format!(
                    "{missing} of {} have no finished recording yet: run the experiment again to resume",
                    plural(record.runs.len() as u64, "run")
                ));
            }
        }
        self.index = index;
        self.record = Some(record);
    }

    /// Puts the recording that `kinetoscope fill` restored in the place of that of its keyframes.
    fn take_restored(
        &mut self,
        file: &mut PathBuf,
        stale: &mut Vec<PathBuf>,
        index: &mut BTreeMap<String, usize>,
    ) {
        if stale.is_empty() {
            return;
        }
        let restored = self.recording(file).ok().as_ref().and_then(restored_file);
        let Some((path, key)) = restored else { return };
        let Some(at) = stale.iter().position(|other| *other == path) else { return };
        let found = self.recording(&path).map(|found| found.provenance().run_key.clone());
        if found.is_ok_and(|found| found == key.as_str()) {
            let run = index.get(&file_name(file)).copied();
            index.extend(run.map(|run| (file_name(&path), run)));
            self.restored.insert(file_name(&path));
            *file = stale.remove(at);
        }
    }

    /// Opens the recordings, with their coordinates in the sweep, in the order of the experiment. Notes and what could not
    /// be read are added to those of the folder.
    pub(crate) fn open(&mut self) -> Vec<(OpenRun, Vec<Coordinate>)> {
        let OpenedRuns { runs, notes, unreadable } = self.opened(recording::opened);
        self.notes.extend(notes);
        self.notes.extend(runs.iter().filter_map(|(run, _)| keyframes_note(run)));
        self.unreadable.extend(unreadable);
        runs
    }

    /// Opens the recordings as [`Self::open`], each with `open`, with notes and what could not be read.
    pub(crate) fn opened(
        &self,
        open: impl Fn(Recording) -> Result<OpenRun, UnreadableRecording>,
    ) -> OpenedRuns {
        let (mut opened, mut notes, mut unreadable) = (Vec::new(), Vec::new(), Vec::new());
        let are_several = self.whole && self.files.len() > 1;
        for path in &self.files {
            let recording = self.recording(path).map_err(UnreadableRecording::from);
            if are_several && recording.as_ref().is_ok_and(is_part) {
                notes.push(part_note(path));
                continue;
            }
            match recording.and_then(&open) {
                Ok(run) => opened.push((file_name(path), run)),
                Err(why) => unreadable.push(why),
            }
        }
        let Some(record) = &self.record else {
            notes.extend(remove_copies(&mut opened));
            opened.sort_by_key(|(_, run)| run.manifest.model.name());
            let manifests: Vec<(&str, &str)> = opened
                .iter()
                .map(|(_, run)| (run.manifest.model.name(), run.recording().manifest()))
                .collect();
            let all_coordinates = coordinates::of_manifests(&manifests);
            let runs = opened.into_iter().map(|(_, run)| run).zip(all_coordinates).collect();
            return OpenedRuns { runs, notes, unreadable };
        };
        let mut ordered: Vec<(usize, OpenRun, Vec<Coordinate>)> = Vec::new();
        for (file, run) in opened {
            let Some(&index) = self.index.get(&finished_name(&file)) else { continue };
            let entry = &record.runs[index];
            if run.run_key == entry.run_key.to_string() || self.restored.contains(&file) {
                ordered.push((index, run, entry.coordinates.clone()));
            } else {
                notes.push(format!(
                    "{file} is stale: its run key is not that of the experiment as run last; left out"
                ));
            }
        }
        ordered.sort_by_key(|(index, ..)| *index);
        let runs = ordered.into_iter().map(|(_, run, coordinates)| (run, coordinates)).collect();
        OpenedRuns { runs, notes, unreadable }
    }
}

/// Removes further recordings of the same run, which would count as replicates; returns their notes.
fn remove_copies(opened: &mut Vec<(String, OpenRun)>) -> Vec<String> {
    let (mut names, mut notes) = (BTreeMap::new(), Vec::new());
    opened.retain(|(file, run)| match names.entry(run.run_key.clone()) {
        Entry::Vacant(place) => {
            place.insert(file.clone());
            true
        }
        Entry::Occupied(first) => {
            notes.push(format!("{file} is of the same run as {}; left out", first.get()));
            false
        }
    });
    notes
}

/// Whether a recording has only an interval of its run, which `kinetoscope zoom` recomputed.
fn is_part(recording: &Recording) -> bool {
    matches!(recording.provenance().stored, StoredFrames::From(_))
}

/// What the analysis of a recording of keyframes lacks.
fn keyframes_note(run: &OpenRun) -> Option<String> {
    let (distance, command) = run.keyframes()?;
    let stored = every(distance, "frame");
    Some(format!(
        "{} holds keyframes ({stored}) and the scalars of all frames: metrics and charts that need the states of all frames, and the replay, are left out; `{command}` restores them",
        run.file
    ))
}

fn part_note(path: &Path) -> String {
    format!("{} is a part of a run, and only whole runs are analyzed; left out", file_name(path))
}

/// File name of the finished recording of a partial file; other names are unchanged.
fn finished_name(file: &str) -> String {
    file.strip_suffix(".partial.mcap")
        .map_or_else(|| file.to_owned(), |stem| format!("{stem}.mcap"))
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
