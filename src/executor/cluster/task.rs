//! A task: a command that executes the runs with given run keys. Any machine with the same folder can execute it repeatedly.

use crate::plan::PlannedRun;
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
    /// Number of threads per run.
    pub threads: usize,
    /// Seconds between checkpoints.
    pub checkpoint_every_s: f64,
}

impl TaskCommand {
    /// The command line for a shell. `keys` is inserted unquoted: run keys separated by commas, or a shell variable.
    #[must_use]
    pub fn line(&self, keys: &str) -> String {
        let mut words = vec![quoted(&self.program.to_string_lossy())];
        words.extend(self.subcommand.map(str::to_owned));
        words.extend([
            quoted(&self.manifest.to_string_lossy()),
            self.destination.clone(),
            format!("--jobs 1 --threads {}", self.threads),
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

/// The run keys of the runs of a task, as `--only-keys` takes them.
#[must_use]
pub fn keys(runs: &[&PlannedRun]) -> String {
    let keys: Vec<&str> = runs.iter().map(|run| run.run_key.as_str()).collect();
    keys.join(",")
}

/// Maximum number of runs per task: an argument has at most 128 KiB on Linux, and a key has 64 digits.
pub const MOST_RUNS_OF_A_TASK: usize = 1000;

/// Distributes the runs, which are in descending order of cost, in turn over the tasks, so that all tasks have about the same
/// cost. A task has at most [`MOST_RUNS_OF_A_TASK`] runs.
#[must_use]
pub fn dealt<'a>(runs: &[&'a PlannedRun], runs_per_task: usize) -> Vec<Vec<&'a PlannedRun>> {
    let tasks = runs.len().div_ceil(runs_per_task.clamp(1, MOST_RUNS_OF_A_TASK));
    (0..tasks).map(|task| runs.iter().copied().skip(task).step_by(tasks).collect()).collect()
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
