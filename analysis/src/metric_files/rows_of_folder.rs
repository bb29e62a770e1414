//! Rows of runs that have no recording in their folder.

use crate::input::recording::OpenRun;
use crate::input::{RUNS_TABLE, RecordingFolder, UnreadableRecording};
use crate::metric_files::runs_store::{stored_analyses, stored_rows};
use crate::run::RunAnalysis;
use kinetoscope_console::text::{plural, shown_path};
use kinetoscope_manifest::Coordinate;
use std::collections::{BTreeMap, BTreeSet};

/// The runs of a folder that has a table of them and no recordings, in the order of the experiment as run last. What is missing is added to
/// the notes of the folder, and to what is unreadable.
pub(crate) fn tabled_runs(source: &mut RecordingFolder) -> Vec<RunAnalysis> {
    let Some(record) = source.record.as_ref().filter(|_| source.is_table) else {
        return Vec::new();
    };
    let stored = match stored_analyses(&source.folder) {
        Ok(stored) => stored,
        Err(error) => {
            source.unreadable.push(error.message.into());
            return Vec::new();
        }
    };
    let rows = stored.into_iter().map(|run| (run.origin.run_key.clone(), run));
    let rows: BTreeMap<String, RunAnalysis> = rows.collect();
    let placed = record.runs.iter().filter_map(|run| {
        let row = rows.get(run.run_key.as_str())?.clone();
        Some(RunAnalysis { file: run.file.clone(), coordinates: run.coordinates.clone(), ..row })
    });
    let placed: Vec<RunAnalysis> = placed.collect();
    let folder = shown_path(&source.folder);
    let missing = record.runs.len() - placed.len();
    if missing > 0 {
        let what = format!(
            "{folder}/{RUNS_TABLE} has no rows of {missing} of {} that this program reads",
            plural(record.runs.len() as u64, "run")
        );
        source.unreadable.push(UnreadableRecording::new(what, "run the manifest again"));
    }
    // Without the path: the report is the same in every folder.
    source.notes.push(format!(
        "there are no recordings: the metrics are those of {RUNS_TABLE}. Charts of single runs, snapshots and replays need frames, which `kinetoscope restore` writes"
    ));
    placed
}

/// Whether the table of a folder has rows of other runs of the experiment than those with a recording here, so that it is kept, with a note.
pub(crate) fn has_other_rows(
    source: &mut RecordingFolder,
    opened: &[(OpenRun, Vec<Coordinate>)],
) -> bool {
    let is_part = |runs: usize| opened.len() < runs && !source.is_remote();
    let Some(record) = source.record.as_ref().filter(|record| is_part(record.runs.len())) else {
        return false;
    };
    if source.is_table {
        return true;
    }
    let rows = stored_rows(&source.folder).unwrap_or_default();
    let read: BTreeSet<&str> = opened.iter().map(|(run, _)| run.run_key.as_str()).collect();
    let keys = rows.iter().map(|row| row.run_key.as_str()).filter(|key| !read.contains(key));
    let keys: BTreeSet<&str> = keys.collect();
    let others = record.runs.iter().filter(|run| keys.contains(run.run_key.as_str())).count();
    if others > 0 {
        let others = plural(others as u64, "run");
        source.notes.push(format!(
            "{RUNS_TABLE} is kept, because it has rows of {others} without a recording here"
        ));
    }
    others > 0
}
