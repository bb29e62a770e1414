//! `check`: reads manifests and reports the plan with its steps, memory and expected time, without executing a run.

use crate::comparison::rerun::{listen, stop_if_interrupted};
use crate::executor::thread_count;
use crate::locking::lock;
use crate::locking::locked_check::LockedCheck;
use crate::locking::locked_runs::Parallel;
use crate::manifests::pipeline;
use crate::manifests::step::Step;
use crate::manifests::{ManifestArguments, ManifestReader, expand};
use crate::messages::Failure;
use crate::messages::result_arguments::ResultArguments;
use crate::output::OutputArguments;
use crate::planning::plan_report::{PlanReport, not_planned};
use crate::planning::planner::Planner;
use clap::Args;
use kinetoscope::interrupt::Interrupt;
use kinetoscope_console::Exit;
use kinetoscope_manifest::Override;
use serde_json::{Value as Json, json};
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// Read manifests and print the plan: runs, steps, disk space, memory and expected time.
#[derive(Debug, Args)]
pub(crate) struct CheckArguments {
    /// Manifests (TOML files), or folders of manifests
    #[arg(required_unless_present = "locked", value_name = "MANIFEST")]
    manifests: Vec<PathBuf>,
    #[command(flatten)]
    manifest: ManifestArguments,
    #[command(flatten)]
    output: OutputArguments,
    /// Number of runs in parallel that the expected time assumes [default: number of CPUs]
    #[arg(long, value_name = "N", value_parser = thread_count, help_heading = "Execution")]
    jobs: Option<NonZeroUsize>,
    /// Run the manifests of a lock file, or those named here, and compare the messages with those that are locked
    #[arg(long, conflicts_with = "set", help_heading = "Lock file")]
    locked: bool,
    /// Run the slow manifests as well: those of more than 5 s by their number of steps
    #[arg(long, requires = "locked", help_heading = "Lock file")]
    all: bool,
    /// Of the named manifests, run those that take at most 5 s, and compare the others with their locked values; skip other files
    #[arg(long, requires = "locked", conflicts_with = "all", help_heading = "Lock file")]
    quick: bool,
    /// Compare the finished recordings of the output folder, and run only what is missing there
    #[arg(long, requires = "locked", help_heading = "Lock file")]
    recorded: bool,
    /// Folder with recordings of the locked runs, such as those of an earlier CI job, for the particle and both values of a
    /// difference [default: the output folder]
    #[arg(long, requires = "locked", value_name = "DIR", help_heading = "Lock file")]
    earlier: Option<PathBuf>,
    /// Append the result in Markdown to a file, such as $GITHUB_STEP_SUMMARY
    #[arg(long, requires = "locked", value_name = "FILE", help_heading = "Lock file")]
    summary: Option<PathBuf>,
    /// The lock file
    #[arg(long, requires = "locked", value_name = "FILE", default_value = lock::USUAL, help_heading = "Lock file")]
    lock_file: PathBuf,
    #[command(flatten)]
    result: ResultArguments,
}

impl CheckArguments {
    /// Checks every manifest; an error in one does not hide those of the others.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        let checked = match self.locked {
            true => self.compare_with_lock(),
            false => self.check_all(),
        };
        self.result.concluded(checked.unwrap_or_else(|failure| self.result.failed(&failure)))
    }

    fn compare_with_lock(&self) -> Result<Exit, Failure> {
        let recordings = self.output.folder()?;
        let check = LockedCheck {
            earlier: self.earlier.clone().unwrap_or_else(|| recordings.clone()),
            summary: self.summary.as_deref(),
            lock_file: &self.lock_file,
            bundle: None,
            manifests: &self.manifests,
            all: self.all,
            quick: self.quick,
            recordings,
            recorded: self.recorded,
            parallel: Parallel { jobs: self.jobs, threads: None },
            result: &self.result,
        };
        check.execute()
    }

    fn check_all(&self) -> Result<Exit, Failure> {
        let interrupt = &listen()?;
        let overrides = self.manifest.overrides()?;
        let output = self.output.folder()?;
        let reader = ManifestReader::new(output, None);
        let steps = pipeline::order(&expand(&self.manifests)?, &overrides, &reader)?;
        let (mut exit, mut checked, mut errors) = (Exit::Done, Vec::new(), Vec::new());
        for step in &steps {
            match self.check(step, &overrides, &reader, interrupt) {
                Ok(json) => checked.push(json),
                Err(failure) => {
                    exit = exit.worst(failure.report());
                    errors.push(failure.plain_text());
                }
            }
            if matches!(exit, Exit::Signal(_)) {
                break;
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
        interrupt: &Interrupt,
    ) -> Result<Json, Failure> {
        if let Some(why) = reader.missing_start(step) {
            self.result.say(&not_planned(step, why)?);
            return Ok(json!({ "manifest": step.manifest, "pending": step.starts_from }));
        }
        let experiment = reader.read(&step.manifest, step.overrides(overrides))?;
        let planner = Planner {
            output: &self.output,
            keys: None,
            force: false,
            jobs: self.jobs,
            is_outline: true,
            interrupt,
            verbosity: self.result.verbosity(),
        };
        let planned = planner.plan(&experiment)?;
        stop_if_interrupted(interrupt)?;
        planned.reject_invalid_starts(&experiment)?;
        let rerun = planner.rerun(&experiment, &planned)?;
        let (manifest, rerun) = (&step.manifest, rerun.as_ref());
        let checked = PlanReport::new(manifest, &experiment, &planned, rerun, interrupt);
        stop_if_interrupted(interrupt)?;
        self.result.say(&checked.text());
        Ok(checked.json())
    }
}
