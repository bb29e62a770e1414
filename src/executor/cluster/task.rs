//! A task: a command that executes the runs with given run keys. Any machine with the same folder can execute it repeatedly.

use crate::plan::PlannedRun;
use kinetoscope_manifest::RunKey;
use std::path::PathBuf;

/// The part of the command that all tasks of a plan share. Every path is absolute.
#[derive(Clone, Debug)]
pub struct TaskCommand {
    /// This program.
    pub program: PathBuf,
    /// Its subcommand that executes runs, if it has subcommands.
    pub subcommand: Option<&'static str>,
    /// The manifest.
    pub manifest: PathBuf,
    /// The folder to which paths in the manifest are relative, if it is not the manifest's folder.
    pub starts_in: Option<PathBuf>,
    /// The options of the output folder, quoted for a shell.
    pub destination: String,
    /// The overrides of the manifest, `key=value`.
    pub overrides: Vec<String>,
    /// Whether a task analyzes its recordings.
    pub analyze: bool,
    /// Number of threads of a task: for each run in turn, or for so many runs at a time whose metrics alone are kept.
    pub threads: usize,
    /// Whether its runs leave rows instead of recordings.
    pub is_of_rows: bool,
    /// Seconds between checkpoints.
    pub checkpoint_every_s: f64,
}

impl TaskCommand {
    /// The command line for a shell. `keys` is inserted unquoted: those of a [`Task`], or a shell variable.
    #[must_use]
    pub fn line(&self, keys: &str) -> String {
        let mut words = vec![quoted(&self.program.to_string_lossy())];
        words.extend(self.subcommand.map(str::to_owned));
        let [jobs, threads] = if self.is_of_rows { [self.threads, 1] } else { [1, self.threads] };
        words.extend([
            quoted(&self.manifest.to_string_lossy()),
            self.destination.clone(),
            format!("--jobs {jobs} --threads {threads}"),
            format!("--checkpoint-every {}", self.checkpoint_every_s),
            "--quiet".to_owned(),
        ]);
        words.extend(self.overrides.iter().map(|text| format!("--set {}", quoted(text))));
        if self.analyze {
            words.push("--analyze".to_owned());
        }
        if let Some(folder) = &self.starts_in {
            words.push(format!("--start-from-dir {}", quoted(&folder.to_string_lossy())));
        }
        words.push(format!("--only-keys {keys}"));
        words.join(" ")
    }
}

/// The runs of a task.
#[derive(Debug)]
pub struct Task<'a> {
    /// The runs that it executes.
    pub runs: Vec<&'a PlannedRun>,
    /// Their run keys, as `--only-keys` takes them.
    pub keys: String,
}

/// Maximum number of runs per task: an argument has at most 128 KiB on Linux, and a key has 64 digits.
pub const MOST_RUNS_OF_A_TASK: usize = 1000;

/// Distributes the runs, which are in descending order of cost, in turn over the tasks, so that all tasks have about the same
/// cost. A task has at most [`MOST_RUNS_OF_A_TASK`] runs.
#[must_use]
pub fn dealt<'a>(runs: &[&'a PlannedRun], runs_per_task: usize) -> Vec<Task<'a>> {
    let tasks = runs.len().div_ceil(runs_per_task.clamp(1, MOST_RUNS_OF_A_TASK));
    let task = |task| {
        let runs: Vec<&PlannedRun> = runs.iter().copied().skip(task).step_by(tasks).collect();
        let keys: Vec<&str> = runs.iter().map(|run| run.run_key.as_str()).collect();
        Task { keys: keys.join(","), runs }
    };
    (0..tasks).map(task).collect()
}

/// Distributes runs that leave rows over tasks of neighboring run keys: of each, the first and the last key name all. As keys are hashes, the
/// costs of the tasks are about the same. No task spans two keys that are `divided` by an active one.
#[must_use]
pub fn in_intervals<'a>(
    runs: &[&'a PlannedRun],
    runs_per_task: usize,
    divided: impl Fn(&RunKey, &RunKey) -> bool,
) -> Vec<Task<'a>> {
    let mut sorted = runs.to_vec();
    sorted.sort_unstable_by_key(|run| run.run_key);
    let task = |runs: &[&'a PlannedRun]| {
        let [first, last] = [runs.first(), runs.last()].map(|run| run.map(|run| run.run_key));
        let keys = first.zip(last).map(|(first, last)| interval(&first, &last));
        Task { keys: keys.unwrap_or_default(), runs: runs.to_vec() }
    };
    let parts = sorted.chunk_by(|one, next| !divided(&one.run_key, &next.run_key));
    parts.flat_map(|part| part.chunks(runs_per_task.max(1))).map(task).collect()
}

/// What divides the first and the last key of an interval.
const TO: char = '-';

fn interval(first: &RunKey, last: &RunKey) -> String {
    format!("{}{TO}{}", first.as_str(), last.as_str())
}

/// The first and the last key of an interval; `None` for a single key.
#[must_use]
pub fn ends_of_interval(text: &str) -> Option<(RunKey, RunKey)> {
    let (first, last) = text.split_once(TO)?;
    RunKey::from_hex(first).zip(RunKey::from_hex(last))
}

/// Quotes a word for a shell.
#[must_use]
pub fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn a_quoted_word_stands_for_itself() {
        assert_eq!(quoted("a b$c"), "'a b$c'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
    }
}
