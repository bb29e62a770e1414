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

    /// Whether a task of an interval is between two keys, in ascending order.
    pub(super) fn divide(&self, one: &RunKey, next: &RunKey) -> bool {
        self.intervals.iter().any(|(first, _)| (one..next).contains(&first))
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

#[cfg(test)]
mod tests {
    use super::ActiveTasks;
    use kinetoscope_manifest::RunKey;

    fn key(digit: char) -> RunKey {
        RunKey::from_hex(&digit.to_string().repeat(64)).unwrap()
    }

    /// Guarantee: runs of an active interval are not submitted again, neither by their own keys nor within another interval.
    #[test]
    fn active_interval_has_its_runs_and_divides_others() {
        let mut live = ActiveTasks::default();
        live.add(&format!("{}-{}", key('4').as_str(), key('6').as_str()), true);
        live.add(&[key('a'), key('b')].map(|key| key.as_str().to_owned()).join(","), false);
        let has =
            |digits: &str| digits.chars().map(|digit| live.has(&key(digit))).collect::<Vec<_>>();
        assert_eq!(has("3456789ab"), [false, true, true, true, false, false, false, true, true]);
        assert!(live.divide(&key('3'), &key('7')));
        assert!(!live.divide(&key('1'), &key('3')) && !live.divide(&key('7'), &key('9')));
    }
}
