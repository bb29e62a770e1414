//! A task: "do the runs with these content keys", as a command that any machine with the same folder can run, again and again.

use crate::plan::PlannedRun;
use std::path::PathBuf;

/// What all tasks of a plan have in common. Every path is absolute.
#[derive(Clone, Debug)]
pub struct TaskCommand {
    /// This program.
    pub program: PathBuf,
    /// Its subcommand that executes runs, if it has subcommands.
    pub subcommand: Option<&'static str>,
    /// The manifest.
    pub manifest: PathBuf,
    /// The folder that paths in it are relative to, where it is not the manifest's own.
    pub starts_in: Option<PathBuf>,
    /// The part of a shell's command line that says where recordings go.
    pub destination: String,
    /// The overrides of the manifest, `key=value`.
    pub overrides: Vec<String>,
    /// Whether it has its recordings analyzed.
    pub analyze: bool,
    /// Threads that a run computes with.
    pub threads: usize,
    /// Seconds between checkpoints.
    pub checkpoint_every_s: f64,
}

impl TaskCommand {
    /// The command line for a shell. `keys` is put in as it is: content keys with commas between, or a shell's variable.
    #[must_use]
    pub fn line(&self, keys: &str) -> String {
        let mut words = vec![quoted(&self.program.display().to_string())];
        words.extend(self.subcommand.map(str::to_owned));
        words.extend([
            quoted(&self.manifest.display().to_string()),
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
            words.push(format!("--start-from-dir {}", quoted(&folder.display().to_string())));
        }
        words.push(format!("--only-keys {keys}"));
        words.join(" ")
    }
}

/// The content keys of a task's runs, as `--only-keys` takes them.
#[must_use]
pub fn keys(runs: &[&PlannedRun]) -> String {
    let keys: Vec<&str> = runs.iter().map(|run| run.content_key.as_str()).collect();
    keys.join(",")
}

/// Runs that a task has at most: one word of a command line holds 128 KiB on Linux, and a key has 64 digits.
pub const MOST_RUNS_OF_A_TASK: usize = 1000;

/// Deals the runs, which come in the order of their cost, like cards: every task gets runs of about the same cost in all.
/// Fewer a task than asked for where that is more than [`MOST_RUNS_OF_A_TASK`].
#[must_use]
pub fn dealt<'a>(runs: &[&'a PlannedRun], runs_per_task: usize) -> Vec<Vec<&'a PlannedRun>> {
    let tasks = runs.len().div_ceil(runs_per_task.clamp(1, MOST_RUNS_OF_A_TASK));
    (0..tasks).map(|task| runs.iter().copied().skip(task).step_by(tasks).collect()).collect()
}

/// A word of a shell's command line that stands for itself.
pub(crate) fn quoted(word: &str) -> String {
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
