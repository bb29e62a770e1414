//! The plan: all runs of an experiment with their content keys, what is there already, and what the rest will take.

pub mod prune;
pub mod restart_files;
pub mod why;

use crate::run::{Assignment, Estimate, estimate};
use kinetoscope_manifest::{ContentKey, Experiment, Run, content_key};
use kinetoscope_physics::model::Refusal;
use kinetoscope_physics::physics_version;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use kinetoscope_recording::file;
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::Outcome;
use rayon::prelude::*;
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

/// One run of the plan.
#[derive(Debug)]
pub struct PlannedRun {
    /// The run as the manifest expands to it.
    pub run: Run,
    /// The canonical text of its manifest.
    pub canonical: String,
    /// What identifies its result.
    pub content_key: ContentKey,
    /// The recording's file name without its ending.
    pub stem: String,
    /// What there is of it.
    pub status: Status,
}

/// What there is of a run.
#[derive(Debug)]
pub enum Status {
    /// Its recording is there, with this outcome.
    Done(Outcome),
    /// It is to be done, and will take this.
    ToDo(Estimate),
    /// It can't be done.
    Refused(Refusal),
}

/// All runs of an experiment.
#[derive(Debug)]
pub struct Plan {
    /// Where the recordings go: the output folder and the experiment's name.
    pub folder: PathBuf,
    /// The runs, in the manifest's order.
    pub runs: Vec<PlannedRun>,
}

impl Plan {
    /// Plans all runs of `experiment` below `output`. With `force` nothing counts as done.
    #[must_use]
    pub fn new(experiment: &Experiment, output: &Path, force: bool) -> Self {
        Self::of(experiment, output, force, |_| true)
    }

    /// Plans only the runs with these content keys.
    ///
    /// # Errors
    /// The first key that no run has.
    pub fn of_keys(
        experiment: &Experiment,
        output: &Path,
        force: bool,
        keys: &[String],
    ) -> Result<Self, String> {
        let wanted: HashSet<&str> = keys.iter().map(String::as_str).collect();
        let plan = Self::of(experiment, output, force, |key| wanted.contains(key.as_str()));
        let planned: HashSet<&str> = plan.runs.iter().map(|run| run.content_key.as_str()).collect();
        match keys.iter().find(|key| !planned.contains(key.as_str())) {
            Some(unknown) => Err(unknown.clone()),
            None => Ok(plan),
        }
    }

    /// The starts of all runs that are to be done are built, to be refused early: on all processors.
    fn of(
        experiment: &Experiment,
        output: &Path,
        force: bool,
        wanted: impl Fn(&ContentKey) -> bool + Sync,
    ) -> Self {
        let folder = output.join(&experiment.name);
        let planned = |run: &Run| {
            let canonical = run.manifest.canonical();
            let physics_version = physics_version(&run.manifest.model);
            let content_key = content_key(&canonical, physics_version, SCHEMA_VERSION);
            if !wanted(&content_key) {
                return None;
            }
            let stem = run.file_stem(&experiment.name, &content_key, experiment.replicates);
            let there = (!force).then(|| finished(&folder, &stem, &content_key)).flatten();
            let status = match there {
                Some(outcome) => Status::Done(outcome),
                None => match estimate(&run.manifest) {
                    Ok(estimate) => Status::ToDo(estimate),
                    Err(refusal) => Status::Refused(refusal),
                },
            };
            Some(PlannedRun { run: run.clone(), canonical, content_key, stem, status })
        };
        let runs = experiment.runs.par_iter().filter_map(planned).collect();
        Self { folder, runs }
    }

    /// The runs that are to be done.
    #[must_use]
    pub fn to_do(&self) -> Vec<&PlannedRun> {
        self.runs.iter().filter(|run| matches!(run.status, Status::ToDo(_))).collect()
    }

    /// The runs whose recordings exist and are finished, with their outcomes.
    pub fn finished(&self) -> impl Iterator<Item = (&PlannedRun, &Outcome)> {
        self.runs.iter().filter_map(|run| match &run.status {
            Status::Done(outcome) => Some((run, outcome)),
            Status::ToDo(_) | Status::Refused(_) => None,
        })
    }

    /// The runs that are to be done, the costliest first: then no long run is left alone at the end.
    #[must_use]
    pub fn to_do_by_cost(&self) -> Vec<&PlannedRun> {
        let mut runs = self.to_do();
        let cost = |run: &PlannedRun| run.estimate().map_or(0.0, |estimate| estimate.relative_cost);
        runs.sort_by(|one, other| cost(other).total_cmp(&cost(one)));
        runs
    }

    /// The runs that can't be done, with the reason.
    pub fn refused(&self) -> impl Iterator<Item = (&PlannedRun, &Refusal)> {
        self.runs.iter().filter_map(|run| match &run.status {
            Status::Refused(refusal) => Some((run, refusal)),
            Status::Done(_) | Status::ToDo(_) => None,
        })
    }

    /// Upper estimate of the bytes still to be written.
    #[must_use]
    pub fn bytes_to_write(&self) -> u64 {
        self.runs
            .iter()
            .map(|run| match &run.status {
                Status::ToDo(estimate) => estimate.bytes,
                Status::Done(_) | Status::Refused(_) => 0,
            })
            .fold(0, u64::saturating_add)
    }

    /// Upper estimate of the bytes that the `jobs` largest recordings still need; what a stopped run left has its room.
    #[must_use]
    pub fn bytes_at_once(&self, jobs: usize) -> u64 {
        let needed = |run: &PlannedRun| {
            let left = fs::metadata(file::partial_path(&self.folder, &run.stem));
            let there = left.map_or(0, |file| file.len());
            run.estimate().map(|estimate| estimate.bytes.saturating_sub(there))
        };
        let mut bytes: Vec<u64> = self.runs.iter().filter_map(needed).collect();
        bytes.sort_unstable_by(|one, other| other.cmp(one));
        bytes.into_iter().take(jobs).fold(0, u64::saturating_add)
    }
}

impl PlannedRun {
    /// The run as it is handed to [`crate::run::execute`].
    #[must_use]
    pub fn assignment<'a>(&'a self, folder: &'a Path) -> Assignment<'a> {
        Assignment {
            manifest: &self.run.manifest,
            canonical: &self.canonical,
            content_key: self.content_key.as_str(),
            folder,
            stem: &self.stem,
        }
    }

    /// What it will take, if it is to be done.
    #[must_use]
    pub fn estimate(&self) -> Option<&Estimate> {
        match &self.status {
            Status::ToDo(estimate) => Some(estimate),
            Status::Done(_) | Status::Refused(_) => None,
        }
    }

    /// The outcome of its recording as it is now in `folder`: finished, and with the whole key.
    #[must_use]
    pub fn recorded(&self, folder: &Path) -> Option<Outcome> {
        finished(folder, &self.stem, &self.content_key)
    }

    /// The outcome of a recording, where it is this run's: finished, and with the whole key.
    #[must_use]
    pub fn outcome_in(&self, recording: &Recording) -> Option<Outcome> {
        outcome(recording, &self.content_key)
    }

    /// The recording's file name.
    #[must_use]
    pub fn file_name(&self) -> String {
        format!("{}.mcap", self.stem)
    }
}

/// The outcome of a recording that is there, is finished and carries the whole key: the file's name alone proves nothing.
fn finished(folder: &Path, stem: &str, content_key: &ContentKey) -> Option<Outcome> {
    outcome(&Recording::open(&folder.join(format!("{stem}.mcap"))).ok()?, content_key)
}

fn outcome(recording: &Recording, content_key: &ContentKey) -> Option<Outcome> {
    let provenance = recording.provenance();
    match provenance.outcome.clone()? {
        Outcome::Interrupted => None,
        outcome => (provenance.content_key == content_key.as_str()).then_some(outcome),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    /// A disk that was full and has just the missing room again must do.
    #[test]
    fn what_a_stopped_run_left_needs_no_more_room() {
        let output = tempfile::tempdir().unwrap();
        let experiment =
            kinetoscope_manifest::parse("seed = 1\n[model.gas]\n", "kept.toml", &[]).unwrap();
        let plan = Plan::new(&experiment, output.path(), false);
        let whole = plan.bytes_at_once(1);
        fs::create_dir_all(&plan.folder).unwrap();
        let partial = file::partial_path(&plan.folder, &plan.runs[0].stem);
        fs::write(partial, [0; 1000]).unwrap();
        assert_eq!(plan.bytes_at_once(1), whole - 1000);
    }
}
