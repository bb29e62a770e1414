//! The tasks of one plan that an engine has queued or runs.

use std::collections::HashSet;

/// The active tasks of one plan.
#[derive(Debug, Default)]
pub struct ActiveTasks {
    /// The run keys of their runs.
    pub keys: HashSet<String>,
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
        self.keys.extend(keys.split(',').map(str::to_owned));
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
