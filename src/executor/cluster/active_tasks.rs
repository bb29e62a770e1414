//! The tasks of one plan that an engine has queued or runs.

use crate::executor::cluster::task::ends_of_interval;
use kinetoscope_manifest::RunKey;
use std::collections::HashSet;

/// The active tasks of one plan.
#[derive(Debug, Default)]
pub struct ActiveTasks {
    /// The run keys of their runs.
    keys: HashSet<RunKey>,
    /// The first and the last key of tasks that name only these.
    intervals: Vec<(RunKey, RunKey)>,
    /// Number of running tasks.
    pub running: usize,
    /// Number of tasks that wait for their start.
    pub waiting: usize,
    /// Number of tasks that are not started until a person acts.
    pub held: usize,
    /// Why they are held, and the remedy; empty if there are none.
    pub hold_reasons: String,
}

impl ActiveTasks {
    /// Adds a running or waiting task by its line of run keys.
    pub(super) fn add(&mut self, keys: &str, runs: bool) {
        self.add_keys(keys);
        if runs { self.running += 1 } else { self.waiting += 1 }
    }

    /// Adds a held task by its line of run keys.
    pub(super) fn add_held(&mut self, keys: &str) {
        self.add_keys(keys);
        self.held += 1;
    }

    fn add_keys(&mut self, keys: &str) {
        match ends_of_interval(keys) {
            Some(ends) => self.intervals.push(ends),
            None => self.keys.extend(keys.split(',').filter_map(RunKey::from_hex)),
        }
    }

    /// Whether one of the tasks executes the run with this key.
    #[must_use]
    pub fn has(&self, key: &RunKey) -> bool {
        let is_in = |(first, last): &(RunKey, RunKey)| (first..=last).contains(&key);
        self.keys.contains(key) || self.intervals.iter().any(is_in)
    }

    /// Whether no task runs or waits.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.running + self.waiting == 0
    }

    /// Formats the number of tasks of each kind.
    #[must_use]
    pub fn summary(&self) -> String {
        let text = format!("{} tasks running, {} waiting", self.running, self.waiting);
        if self.held == 0 { text } else { format!("{text}, {} held back", self.held) }
    }
}
