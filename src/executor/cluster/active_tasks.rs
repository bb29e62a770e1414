//! The tasks of one plan that an engine has queued or runs.

use std::collections::HashSet;

/// The tasks that the engine has of one plan.
#[derive(Debug, Default)]
pub struct ActiveTasks {
    /// The run keys of their runs.
    pub keys: HashSet<String>,
    /// Tasks that run now.
    pub running: usize,
    /// Tasks that wait, and will be started.
    pub waiting: usize,
    /// Tasks that are not started until a person acts.
    pub held: usize,
    /// Why those are not, and what to type; empty if there are none.
    pub hold_reasons: String,
}

impl ActiveTasks {
    /// Adds a task that runs or will: its line of run keys, and whether it runs.
    pub(super) fn add(&mut self, keys: &str, runs: bool) {
        self.add_keys(keys);
        if runs { self.running += 1 } else { self.waiting += 1 }
    }

    /// Adds a task that is not started until a person acts: its line of run keys.
    pub(super) fn add_held(&mut self, keys: &str) {
        self.add_keys(keys);
        self.held += 1;
    }

    fn add_keys(&mut self, keys: &str) {
        self.keys.extend(keys.split(',').map(str::to_owned));
    }

    /// Whether nothing goes on unless a person acts or more is submitted.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.running + self.waiting == 0
    }

    /// How many tasks there are of each kind.
    #[must_use]
    pub fn words(&self) -> String {
        let words = format!("{} tasks running, {} waiting", self.running, self.waiting);
        if self.held == 0 { words } else { format!("{words}, {} held back", self.held) }
    }
}
