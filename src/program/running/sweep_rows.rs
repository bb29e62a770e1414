//! Which runs of a sweep have a row in its journal.

use crate::messages::{Failure, bad};
use crate::running::journal::PlaceOfRow;
use kinetoscope::executor::cluster::task::ends_of_interval;
use kinetoscope_manifest::{Run, RunKey, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use rayon::prelude::*;
use std::collections::HashSet;

/// The run key of a run of the experiment.
fn key_of(run: &Run) -> RunKey {
    let physics_version = kind_of(&run.manifest.model).physics_version;
    run_key(&run.manifest.canonical(), physics_version, SCHEMA_VERSION)
}

/// The rows of the runs: which have one in the journal, and where.
pub(crate) struct Rows {
    /// The run keys in the order of the sweep.
    pub(crate) keys: Vec<RunKey>,
    /// The indices of the runs in the order of their keys.
    by_key: Vec<u32>,
    /// The place of each run's row in the journal; 0 without one.
    pub(crate) places: Vec<PlaceOfRow>,
}

impl Rows {
    pub(crate) fn of(runs: &[Run]) -> Self {
        let keys: Vec<RunKey> = runs.par_iter().map(key_of).collect();
        let mut by_key: Vec<u32> = (0..keys.len() as u32).collect();
        by_key.par_sort_unstable_by_key(|run| (keys[*run as usize], *run));
        let places = vec![0; keys.len()];
        Self { keys, by_key, places }
    }

    /// The first run with a key: variants of another name may be the same run.
    pub(crate) fn find(&self, key: &RunKey) -> Option<usize> {
        let at = self.by_key.partition_point(|run| self.keys[*run as usize] < *key);
        let run = *self.by_key.get(at)? as usize;
        (self.keys[run] == *key).then_some(run)
    }

    pub(crate) fn find_text(&self, key: &str) -> Option<usize> {
        self.find(&RunKey::from_hex(key)?)
    }

    /// The runs that a task names, by their keys or by the first and the last key of an interval.
    ///
    /// # Errors
    /// A key of no run.
    pub(crate) fn named(&self, keys: &[String]) -> Result<HashSet<usize>, Failure> {
        let mut named = HashSet::new();
        for text in keys {
            let ends =
                ends_of_interval(text).or_else(|| RunKey::from_hex(text).map(|key| (key, key)));
            let known = ends
                .filter(|(first, last)| [first, last].iter().all(|key| self.find(key).is_some()));
            let Some((first, last)) = known else {
                return Err(bad(format!("no run has the key {text}"))
                    .help("submit the runs again: the manifest or the program has changed since"));
            };
            let from = self.by_key.partition_point(|run| self.keys[*run as usize] < first);
            let to = self.by_key.partition_point(|run| self.keys[*run as usize] <= last);
            named.extend(
                self.by_key.get(from..to).unwrap_or_default().iter().map(|run| *run as usize),
            );
        }
        Ok(named)
    }

    /// The place of the row of a run.
    pub(crate) fn place(&self, run: usize) -> PlaceOfRow {
        self.find(&self.keys[run]).map_or(0, |first| self.places[first])
    }

    /// The runs to be executed, each key once.
    pub(crate) fn to_do(&self) -> Vec<usize> {
        let is_first = |run: &usize| self.find(&self.keys[*run]) == Some(*run);
        (0..self.keys.len()).filter(|run| self.places[*run] == 0).filter(is_first).collect()
    }
}
