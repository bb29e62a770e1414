//! The rows of tasks: each task appends to a shard of its own, a journal next to that of the sweep, and the program that writes the table
//! takes them over.

use crate::running::journal::{Journal, PlaceOfRow, each_row_from};
use crate::running::sweep_rows::Rows;
use kinetoscope::executor::cluster::queue::Results;
use kinetoscope::plan::PlannedRun;
use kinetoscope_analysis::each_stored_outcome;
use kinetoscope_recording::recorder::Outcome;
use sha2::{Digest as _, Sha256};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::{fs, io};

/// Name of the journal in the folder of the experiment; those of shards go on after a point.
pub(crate) const JOURNAL: &str = ".runs.journal";

/// The shard of a task with these keys.
pub(crate) fn shard_of(folder: &Path, keys: &[String]) -> PathBuf {
    let digest = Sha256::digest(keys.join(","));
    let name: String = digest.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    folder.join(format!("{JOURNAL}.{name}"))
}

fn shards_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let is_shard = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        name.strip_prefix(JOURNAL).is_some_and(|rest| rest.starts_with('.'))
    };
    let entries = fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
    let mut paths: Vec<PathBuf> =
        entries.filter(|path| path.as_ref().map_or(true, is_shard)).collect::<io::Result<_>>()?;
    paths.sort();
    Ok(paths)
}

/// How far the shards were read.
pub(crate) type ReadShards = HashMap<PathBuf, PlaceOfRow>;

/// Takes over the rows that all shards have gained since they were read last. The shards stay: tasks may write them. The keys of other runs
/// are added to `others`.
///
/// # Errors
/// A folder that cannot be read or written.
pub(crate) fn take_shards(
    folder: &Path,
    rows: &mut Rows,
    journal: &mut Journal,
    others: &mut HashSet<String>,
    read: &mut ReadShards,
) -> io::Result<()> {
    for path in shards_in(folder)? {
        let mut written = Ok(());
        let from = read.get(&path).copied().unwrap_or_default();
        let end = each_row_from(&path, from, |row| match rows.find_text(&row.run_key) {
            Some(run) if rows.places[run] == 0 && written.is_ok() => {
                written = journal.append(row).map(|place| rows.places[run] = place);
            }
            Some(_) => {}
            None => {
                others.insert(row.run_key.clone());
            }
        });
        let end = end.map_err(|error| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let what = format!("{name}: {error}; remove it if no task has written it");
            io::Error::new(error.kind(), what)
        })?;
        written?;
        read.insert(path, end);
    }
    journal.sync()
}

/// Removes all shards, also those of other runs.
///
/// # Errors
/// A folder that cannot be written.
pub(crate) fn remove_shards(folder: &Path) -> io::Result<()> {
    shards_in(folder)?.iter().try_for_each(fs::remove_file)
}

/// Calls `each` with the key of every row in the folder: in the table, the journal and the shards of all tasks.
pub(crate) fn each_key_in(folder: &Path, mut each: impl FnMut(&str)) {
    let journals = shards_in(folder).unwrap_or_default().into_iter().chain([folder.join(JOURNAL)]);
    for path in journals {
        // What cannot be read is executed again.
        let _ = each_row_from(&path, 0, |row| each(&row.run_key));
    }
    let _ = each_stored_outcome(folder, |row| each(&row.run_key));
}

/// The rows that tasks leave for the program that waits for them.
pub(crate) struct Shards<'a> {
    pub(crate) folder: &'a Path,
    pub(crate) rows: &'a mut Rows,
    pub(crate) journal: &'a mut Journal,
    pub(crate) read: ReadShards,
}

impl Shards<'_> {
    /// Size of the rows in shards.
    fn bytes(&self) -> u64 {
        self.read.values().sum()
    }
}

impl Results for Shards<'_> {
    fn scan(&mut self) -> io::Result<()> {
        // Rows of other runs are found before the first task, and when the table is written.
        let others = &mut HashSet::new();
        take_shards(self.folder, self.rows, self.journal, others, &mut self.read)
    }

    /// A fault is reported when the table is written.
    fn outcome(&self, run: &PlannedRun) -> Option<Outcome> {
        let found = self.rows.find(&run.run_key)?;
        (self.rows.places[found] != 0).then_some(Outcome::Complete)
    }

    fn unfinished_bytes(&self, _: &[&PlannedRun]) -> u64 {
        self.bytes()
    }

    fn trace(&self, _: &[&PlannedRun]) -> u64 {
        self.bytes()
    }
}
