//! `check`: reads manifests and reports the plan with its steps, memory and expected time, without executing a run.

use crate::cli::executor::at_least_one;
use crate::cli::exit::Exit;
use crate::cli::expected_time;
use crate::cli::lock;
use crate::cli::locked::LockedCheck;
use crate::cli::manifests::{ManifestArguments, ManifestReader, NoRecording, expand};
use crate::cli::messages::{Failure, bad, counted, describe, plural};
use crate::cli::output::OutputArguments;
use crate::cli::pipeline;
use crate::cli::planner::{Planned, Planner};
use crate::cli::program::Program;
use crate::cli::rerun::Metrics;
use crate::cli::result_arguments::ResultArguments;
use crate::cli::step::Step;
use crate::executor::progress::size;
use crate::run::estimate::Estimate;
use clap::Args;
use kinetoscope_manifest::{Experiment, Override};
use kinetoscope_physics::model::Extent;
use serde_json::{Value as Json, json};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Read manifests and print the plan: runs, steps, disk space, memory and expected time.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// Manifests (TOML files), or folders of manifests
    #[arg(required_unless_present = "locked", value_name = "MANIFEST")]
    manifests: Vec<PathBuf>,
    #[command(flatten)]
    manifest: ManifestArguments,
    #[command(flatten)]
    output: OutputArguments,
    /// Number of runs in parallel that the expected time assumes [default: number of CPUs]
    #[arg(long, value_name = "N", value_parser = at_least_one::<NonZeroUsize>, help_heading = "Execution")]
    jobs: Option<NonZeroUsize>,
    /// Run the manifests of a lock file, or those named here, and compare the messages with those that are locked
    #[arg(long, conflicts_with = "set", help_heading = "Lock file")]
    locked: bool,
    /// Run the slow manifests as well: those that took more than 5 s
    #[arg(long, requires = "locked", help_heading = "Lock file")]
    all: bool,
    /// The lock file
    #[arg(long, requires = "locked", value_name = "FILE", default_value = lock::USUAL, help_heading = "Lock file")]
    lock_file: PathBuf,
    #[command(flatten)]
    result: ResultArguments,
}

impl CheckArguments {
    /// Checks every manifest; an error in one does not hide those of the others.
    #[must_use]
    pub fn execute(&self, program: &Program<'_>, metrics: &dyn Metrics) -> Exit {
        let checked = match self.locked {
            true => self.compare_with_lock(program, metrics),
            false => self.check_all(),
        };
        self.result.concluded(checked.unwrap_or_else(|failure| self.result.failed(&failure)))
    }

    fn compare_with_lock(
        &self,
        program: &Program<'_>,
        metrics: &dyn Metrics,
    ) -> Result<Exit, Failure> {
        let check = LockedCheck {
            lock_file: &self.lock_file,
            manifests: &self.manifests,
            all: self.all,
            recordings: self.output.folder()?,
            jobs: self.jobs,
            result: &self.result,
        };
        check.execute(program, metrics)
    }

    fn check_all(&self) -> Result<Exit, Failure> {
        let overrides = self.manifest.overrides()?;
        let output = self.output.folder()?;
        let reader = ManifestReader::new(output, None);
        let steps = pipeline::order(&expand(&self.manifests)?, &overrides, &reader)?;
        let (mut exit, mut checked, mut errors) = (Exit::Done, Vec::new(), Vec::new());
        for step in &steps {
            match self.check(step, &overrides, &reader) {
                Ok(json) => checked.push(json),
                Err(failure) => {
                    exit = exit.worst(failure.report());
                    errors.push(failure.text().to_owned());
                }
            }
        }
        if self.result.json {
            self.result.print_json(&json!({
                "exit_code": exit.code(),
                "experiments": checked,
                "errors": errors,
            }));
        }
        Ok(exit)
    }

    fn check(
        &self,
        step: &Step,
        overrides: &[Override],
        reader: &ManifestReader<'_>,
    ) -> Result<Json, Failure> {
        if let Some(why) = reader.missing_start(step) {
            self.result.say(&not_planned(step, why)?);
            return Ok(json!({ "manifest": step.manifest, "pending": step.starts_from }));
        }
        let experiment = reader.read(&step.manifest, step.overrides(overrides))?;
        let planner = Planner { output: &self.output, keys: None, force: false, jobs: self.jobs };
        let planned = planner.plan(&experiment)?;
        planned.reject_invalid_starts(&experiment)?;
        let rerun = planner.rerun(&experiment, &planned)?;
        let checked = Checked::new(&step.manifest, &experiment, &planned, rerun.as_ref());
        self.result.say(&checked.text());
        Ok(checked.json())
    }
}

/// The plan of an experiment that starts from a run without a recording.
///
/// # Errors
/// A run that failed, or a manifest that cannot be started from.
pub(crate) fn not_planned(step: &Step, why: NoRecording) -> Result<String, Failure> {
    let manifest = step.manifest.display();
    match why {
        NoRecording::Failed(why) => {
            let what = format!("{manifest} cannot start: {why}");
            Err(Failure::new(Exit::RunFailed, what).help("change the manifest that it starts from"))
        }
        NoRecording::Invalid(why) => {
            let what = format!("{manifest} cannot start: {why}");
            Err(bad(what).help("correct the manifest that it starts from"))
        }
        NoRecording::Missing(why) => {
            Ok(format!("{manifest}: planned when the run that it starts from is finished: {why}"))
        }
    }
}

/// A manifest that was checked.
pub(crate) struct Checked<'a> {
    manifest: &'a Path,
    experiment: &'a Experiment,
    planned: &'a Planned,
    /// The plan whose resources are reported: that of a rerun if all runs are finished.
    costs: &'a Planned,
    seconds: Option<f64>,
}

impl<'a> Checked<'a> {
    /// Checks the plan of an experiment. `rerun` is the plan of its rerun if all runs are finished.
    pub(crate) fn new(
        manifest: &'a Path,
        experiment: &'a Experiment,
        planned: &'a Planned,
        rerun: Option<&'a Planned>,
    ) -> Self {
        let costs = rerun.unwrap_or(planned);
        let seconds = expected_time::expected_seconds(&costs.plan, costs.jobs);
        Self { manifest, experiment, planned, costs, seconds }
    }

    fn estimates(&self) -> Vec<&Estimate> {
        self.costs.plan.to_do().into_iter().filter_map(|run| run.estimate()).collect()
    }

    /// Memory of the runs that execute in parallel.
    fn memory(&self) -> u64 {
        let mut memory: Vec<u64> =
            self.estimates().iter().map(|estimate| estimate.memory_bytes).collect();
        memory.sort_unstable_by(|one, other| other.cmp(one));
        memory.into_iter().take(self.costs.jobs).fold(0, u64::saturating_add)
    }

    /// The plan as text.
    pub(crate) fn text(&self) -> String {
        let Planned { plan, jobs, .. } = self.planned;
        let mut text = describe(self.experiment, plan, *jobs, &self.planned.destination());
        let estimates = self.estimates();
        let of = |count: fn(Extent) -> Option<u64>| {
            estimates.iter().filter_map(move |estimate| count(estimate.extent)).collect::<Vec<_>>()
        };
        for (counts, what) in [(of(steps), "step"), (of(events), "event")] {
            if let Some(range) = counted(counts.into_iter(), what) {
                text += &format!("\n  {range} per run");
            }
        }
        if !estimates.is_empty() {
            text += &format!("\n  memory: at most {}", size(self.memory()));
            text += &match self.seconds {
                Some(seconds) => {
                    let of_rerun = if plan.to_do().is_empty() { " for a rerun" } else { "" };
                    let time = expected_time::text(seconds);
                    format!("\n  time: {time}{of_rerun} on this machine")
                }
                None => "\n  time: unknown".to_owned(),
            };
        }
        text += &format!("\n  {}", plural(self.experiment.checks.len() as u64, "check"));
        if !self.experiment.plots.is_empty() {
            text += &format!(", {}", plural(self.experiment.plots.len() as u64, "requested plot"));
        }
        text
    }

    /// The plan as JSON.
    pub(crate) fn json(&self) -> Json {
        let Planned { plan, jobs, .. } = self.planned;
        let estimates = self.estimates();
        let range = |values: Vec<u64>| match (values.iter().min(), values.iter().max()) {
            (Some(min), Some(max)) => json!({ "min": min, "max": max }),
            _ => Json::Null,
        };
        let counts = |count: &dyn Fn(&Estimate) -> Option<u64>| {
            range(estimates.iter().filter_map(|estimate| count(estimate)).collect())
        };
        json!({
            "manifest": self.manifest,
            "experiment": self.experiment.name,
            "model": self.experiment.model(),
            "runs": plan.runs.len(),
            "finished": plan.finished().count(),
            "to_do": plan.to_do().len(),
            "destination": self.planned.destination(),
            "jobs": jobs,
            "particles": counts(&|estimate| Some(estimate.particles)),
            "frames": counts(&|estimate| Some(estimate.frames)),
            "steps": counts(&|estimate| steps(estimate.extent)),
            "events": counts(&|estimate| events(estimate.extent)),
            "bytes": plan.bytes_to_write(),
            "memory_bytes": self.memory(),
            "expected_s": self.seconds,
            "checks": self.experiment.checks.len(),
            "plots": self.experiment.plots.len(),
        })
    }
}

const fn steps(extent: Extent) -> Option<u64> {
    match extent {
        Extent::Steps { total, .. } => Some(total),
        Extent::Events(_) | Extent::Time(_) => None,
    }
}

const fn events(extent: Extent) -> Option<u64> {
    match extent {
        Extent::Events(total) => Some(total),
        Extent::Steps { .. } | Extent::Time(_) => None,
    }
}
