//! The plan of an experiment for the arguments of a command, and where its recordings go.

use crate::messages::exit;
use crate::messages::progress::{PreparationDisplay, Verbosity};
use crate::messages::{Failure, bad, name_of};
use crate::output::OutputArguments;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::outputs::upload::Uploader;
use kinetoscope::plan::Plan;
use kinetoscope::plan::preparation::Preparation;
use kinetoscope_console::Exit;
use kinetoscope_console::Explained as _;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::regular_file::{MAX_MANIFEST_BYTES, read_text};
use kinetoscope_manifest::{Experiment, line_of_key_in_message};
use std::num::NonZeroUsize;
use std::path::Path;

/// What decides the plan of an experiment.
#[derive(Debug)]
pub(crate) struct Planner<'a> {
    pub(crate) output: &'a OutputArguments,
    /// The keys of the runs to plan; all if `None`.
    pub(crate) keys: Option<&'a [String]>,
    pub(crate) force: bool,
    pub(crate) jobs: Option<NonZeroUsize>,
    /// Whether the plan is not executed.
    pub(crate) is_outline: bool,
    /// Stops the plan.
    pub(crate) interrupt: &'a Interrupt,
    /// The amount of output about starts that take long.
    pub(crate) verbosity: Verbosity,
}

/// A plan, and where its recordings go.
#[derive(Debug)]
pub(crate) struct Planned {
    pub(crate) plan: Plan,
    /// The object storage that recordings are uploaded to; `None` if they stay in the plan's folder.
    pub(crate) depot: Option<Uploader>,
    /// Runs in parallel.
    pub(crate) jobs: usize,
}

impl Planned {
    /// Upper estimate of the bytes that are on the disk at once: uploaded recordings are removed.
    pub(crate) fn bytes_at_once(&self) -> u64 {
        let runs = if self.depot.is_some() { self.jobs } else { self.plan.runs.len() };
        self.plan.bytes_at_once(runs)
    }
}

impl Planner<'_> {
    /// Plans an experiment.
    pub(crate) fn plan(&self, experiment: &Experiment) -> Result<Planned, Failure> {
        let folder = self.output.folder()?;
        let depot = self.output.depot(&experiment.name)?;
        let (force, display) = (self.force, PreparationDisplay::new(self.verbosity));
        let on_progress = |done, starts| display.show(done, starts);
        let preparation = Preparation { interrupt: self.interrupt, on_progress: &on_progress };
        let mut plan = match self.keys {
            None if self.is_outline => Plan::outline(experiment, &folder, force, preparation),
            None => Plan::new(experiment, &folder, force, preparation),
            Some(keys) => {
                let plan = Plan::of_keys(experiment, &folder, force, keys, preparation);
                plan.map_err(|key| {
                    bad(format!("no run has the key {key}")).help(
                        "submit the runs again: the manifest or the program has changed since",
                    )
                })?
            }
        };
        drop(display);
        if let Some(depot) = &depot {
            depot.find(&mut plan, self.force).map_err(|error| {
                Failure::of(exit::of_storage(error.is_retryable()), error.message())
            })?;
        }
        let jobs = parallel_runs(self.jobs, plan.to_do().len());
        Ok(Planned { plan, depot, jobs })
    }

    /// The plan of a rerun, if all runs of a plan are finished.
    pub(crate) fn rerun(
        &self,
        experiment: &Experiment,
        planned: &Planned,
    ) -> Result<Option<Planned>, Failure> {
        let is_finished = planned.plan.to_do().is_empty();
        is_finished.then(|| Planner { force: true, ..*self }.plan(experiment)).transpose()
    }
}

/// The number of runs in parallel out of `runs`: as requested, otherwise one per processor.
pub(crate) fn parallel_runs(requested: Option<NonZeroUsize>, runs: usize) -> usize {
    let processors = std::thread::available_parallelism().ok();
    let jobs = requested.or(processors).unwrap_or(NonZeroUsize::MIN).get();
    jobs.min(runs.max(1))
}

impl Planned {
    /// Rejects a plan with a run that cannot be executed.
    pub(crate) fn reject_invalid_starts(&self, experiment: &Experiment) -> Result<(), Failure> {
        let refused: Vec<String> = self
            .plan
            .rejected()
            .map(|(run, reason)| {
                let message = reason.message();
                let place = place_of_reason(experiment, &message.to_string());
                let message = message.about(name_of(run, experiment));
                let failure = Failure::of(Exit::BadInput, message);
                place.map_or_else(|| failure.text(), |place| failure.clone().at(&place).text())
            })
            .collect();
        if refused.is_empty() {
            return Ok(());
        }
        Err(Failure::rendered(Exit::BadInput, refused.join("\n")))
    }

    /// Where the recordings are written, as the plan states it.
    pub(crate) fn destination(&self) -> String {
        let here = shown_path(&self.plan.folder);
        match &self.depot {
            None => here,
            Some(depot) => format!("{} by way of {here}", depot.address()),
        }
    }

    /// Where the recordings are in the end.
    pub(crate) fn address(&self) -> String {
        match &self.depot {
            None => self.plan.folder.to_string_lossy().into_owned(),
            Some(depot) => depot.address().to_string(),
        }
    }
}

/// The file and line of the key that a run's reason names first, if the manifest has that key.
fn place_of_reason(experiment: &Experiment, reason: &str) -> Option<String> {
    let text = read_text(Path::new(&experiment.manifest), MAX_MANIFEST_BYTES).ok()?;
    let line = line_of_key_in_message(&text, reason)?;
    Some(format!("{}:{line}", experiment.manifest))
}
