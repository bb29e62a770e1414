//! Recordings from which other runs start: found by path or by the identity in a canonical manifest, and read once.

use crate::run::recording;
use kinetoscope_console::Explained as _;
use kinetoscope_console::text::shown_path;
use kinetoscope_manifest::model::RecordedState;
use kinetoscope_recording::reader::Outcome;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The recordings that the manifests of one folder may name.
#[derive(Debug)]
pub struct StartFiles {
    folder: PathBuf,
    found: RefCell<BTreeMap<String, Arc<RecordedState>>>,
}

impl StartFiles {
    /// Paths are relative to `folder`. A recording named by its run key is searched in this folder and in the adjacent and inner
    /// folders, by the part of the key at the end of its file name.
    #[must_use]
    pub fn relative_to(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), found: RefCell::default() }
    }

    /// Reads the last state of a recording.
    ///
    /// # Errors
    /// A recording that is missing, damaged, unfinished, or not the named one.
    pub fn read(&self, name: &str) -> Result<Arc<RecordedState>, String> {
        if let Some(state) = self.found.borrow().get(name) {
            return Ok(Arc::clone(state));
        }
        let state = Arc::new(match RecordedState::run_key_of(name) {
            Some(run_key) => self.named_by_key(run_key, name)?,
            None => last_state(&self.folder.join(name))?,
        });
        self.found.borrow_mut().insert(name.to_owned(), Arc::clone(&state));
        Ok(state)
    }

    fn named_by_key(&self, run_key: &str, identity: &str) -> Result<RecordedState, String> {
        // An absolute path if possible, because neither an empty path nor `.` has a parent whose folders can be listed.
        let folder = Path::new(".").join(&self.folder);
        let folder = folder.canonicalize().unwrap_or_else(|_| self.folder.clone());
        let adjacent = folder.parent().map(entries).unwrap_or_default();
        let mut folders = vec![folder.clone()];
        folders.extend(adjacent.into_iter().filter(|path| path.is_dir()));
        folders.extend(entries(&folder).into_iter().filter(|path| path.is_dir()));
        let short = run_key.get(..8).unwrap_or(run_key);
        let endings = [format!("__{short}.mcap"), format!("__{run_key}.mcap")];
        let candidates = folders.iter().flat_map(|folder| entries(folder)).filter(|path| {
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            endings.iter().any(|ending| name.ends_with(ending))
        });
        let mut other = None;
        for path in candidates {
            match last_state(&path) {
                Ok(state) if state.identity() == identity => return Ok(state),
                Ok(_) => other = Some(format!("{} ends in another state", shown_path(&path))),
                Err(why) => other = Some(why),
            }
        }
        Err(other.unwrap_or_else(|| {
            format!(
                "no recording with the run key {run_key} is in {} or an adjacent folder: put it there",
                shown_path(&folder)
            )
        }))
    }
}

/// The entries of a folder, sorted by name; empty if it cannot be read.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

/// The state in the last frame of a finished recording. The whole recording is read, so that any damage is found.
fn last_state(path: &Path) -> Result<RecordedState, String> {
    let recording = recording::open(path).map_err(|error| error.message().clause())?;
    let provenance = recording.provenance();
    match &provenance.outcome {
        Some(Outcome::Complete) => {}
        Some(Outcome::Fault(fault)) => {
            return Err(format!("{} failed: {fault}", shown_path(path)));
        }
        Some(Outcome::Interrupted) | None => {
            return Err(format!("{} is not finished: finish its run first", shown_path(path)));
        }
    }
    let mut last = None;
    for frame in recording.frames().map_err(|error| error.message().clause())? {
        last = frame.map_err(|error| error.message().clause())?.take_state();
    }
    let Some(table) = last else {
        let path = shown_path(path);
        return Err(format!(
            "{path} has no state: record it with \"state\" among [record] channels"
        ));
    };
    let values = (0..table.rows()).flat_map(|row| table.row(row)).copied().collect();
    RecordedState::new(&provenance.model, &provenance.run_key, table.columns().to_vec(), values)
        .map_err(|why| format!("{}: {why}", shown_path(path)))
}
