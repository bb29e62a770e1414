//! Tables of runs that have no recordings.

use super::{OpenRun, RecordingFolder, UnreadableRecording};
use crate::metric_files::document::RUNS_TABLE;
use crate::metric_files::runs_store::{stored_analyses, stored_rows};
use crate::run::RunAnalysis;
use kinetoscope_console::text::{plural, shown_path};
use kinetoscope_manifest::{Coordinate, ExperimentRecord};
use kinetoscope_recording::storage::LocalFolders;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

/// The runs of a folder that has a table of them and no recordings.
pub(super) fn source(folder: &Path) -> RecordingFolder {
    let mut source =
        RecordingFolder::new(Arc::new(LocalFolders), folder.to_owned(), Vec::new(), true);
    source.keeps_table = true;
    match stored_analyses(folder) {
        Ok(runs) => source.tabled = runs,
        Err(error) => source.unreadable.push(error.message.into()),
    }
    source.read_side_car();
    source
}

impl RecordingFolder {
    /// Puts the runs of the table in the order of the experiment as run last.
    pub(super) fn sort_table_by(&mut self, record: ExperimentRecord) {
        let rows = self.tabled.drain(..).map(|run| (run.origin.run_key.clone(), run));
        let mut rows: BTreeMap<String, RunAnalysis> = rows.collect();
        let placed = record.runs.iter().filter_map(|run| {
            let row = rows.remove(run.run_key.as_str())?;
            Some(RunAnalysis { coordinates: run.coordinates.clone(), ..row })
        });
        self.tabled = placed.collect();
        let folder = shown_path(&self.folder);
        let missing = record.runs.len() - self.tabled.len();
        if missing > 0 && self.unreadable.is_empty() {
            let what = format!(
                "{folder}/{RUNS_TABLE} has no rows of {missing} of {} that this program reads",
                plural(record.runs.len() as u64, "run")
            );
            self.unreadable.push(UnreadableRecording::new(what, "run the manifest again"));
        }
        self.notes.push(format!(
            "{folder} has no recordings: the metrics are those of {RUNS_TABLE}. Charts of single runs, snapshots and replays need frames, which `kinetoscope restore` writes"
        ));
        self.name.clone_from(&record.name);
        self.record = Some(record);
    }

    /// Keeps a table that has rows of other runs of the experiment than those with a recording here.
    pub(super) fn keep_other_rows(&mut self, opened: &[(OpenRun, Vec<Coordinate>)]) {
        let Some(record) = &self.record else { return };
        if self.files.is_empty() || opened.len() >= record.runs.len() || self.is_remote() {
            return;
        }
        let rows = stored_rows(&self.folder).unwrap_or_default();
        let read: BTreeSet<&str> = opened.iter().map(|(run, _)| run.run_key.as_str()).collect();
        let keys = rows.iter().map(|row| row.run_key.as_str()).filter(|key| !read.contains(key));
        let keys: BTreeSet<&str> = keys.collect();
        let others = record.runs.iter().filter(|run| keys.contains(run.run_key.as_str())).count();
        if others > 0 {
            self.keeps_table = true;
            let others = plural(others as u64, "run");
            self.notes.push(format!(
                "{RUNS_TABLE} is kept, because it has rows of {others} without a recording here"
            ));
        }
    }
}
