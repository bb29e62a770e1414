//! One experiment from its manifest to its recordings: the plan, what precedes the runs, and the errors of the runs.

use crate::comparison::rerun::stop_if_interrupted;
use crate::executor::{Executor, TaskOptions};
use crate::messages::exit;
use crate::messages::progress::ProgressDisplay;
use crate::messages::{Failure, bad, complain, describe, disk_shortage, plural, summary};
use crate::planning::plan_report::PlanReport;
use crate::planning::planner::{Planned, Planner};
use crate::running::arguments::RunArguments;
use crate::running::results::{self, RunResult};
use kinetoscope::executor::cluster::queue::{self, Recordings, Results};
use kinetoscope::executor::cluster::scheduler::Engine;
use kinetoscope::executor::local;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::outputs::sidecars;
use kinetoscope::plan::prune::StaleFiles;
use kinetoscope::plan::{Plan, PlannedRun};
use kinetoscope::run::RunReport;
use kinetoscope_console::Exit;
use kinetoscope_console::text::{one_line, shown_path};
use kinetoscope_files::output_file;
use kinetoscope_manifest::Experiment;
use kinetoscope_recording::removal::{Removal, remove_leftovers};
use serde_json::{Value as Json, json};
use std::cell::OnceCell;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// One experiment of a call of the program.
pub(crate) struct Execution<'a> {
    pub(crate) arguments: &'a RunArguments,
    pub(crate) manifest: &'a Path,
    /// The overrides of the manifest, `KEY=VALUE`.
    pub(crate) overrides: &'a [String],
    pub(crate) force: bool,
    pub(crate) experiment: Box<Experiment>,
    /// Listens to signals from the first run on.
    pub(crate) interrupt: &'a OnceCell<Interrupt>,
}

/// An experiment after its execution.
pub(crate) struct Executed {
    pub(crate) exit: Exit,
    pub(crate) name: String,
    /// Where its recordings are, if they are complete and can be analyzed.
    pub(crate) destination: Option<String>,
    pub(crate) is_remote: bool,
    /// Its recordings that keep only keyframes and were not restored, so that their analysis lacks what needs all states.
    pub(crate) keyframes: Vec<PathBuf>,
    /// The summary, if it is requested.
    pub(crate) json: Option<Json>,
}

/// An experiment before its runs.
pub(crate) enum Begun {
    /// Its runs are planned. After an interrupt, the plan is incomplete.
    Planned(Planned),
    /// None of its runs is to be executed.
    Ended(Executed),
}

impl Execution<'_> {
    /// Plans the runs that have no recording yet, and prints the plan.
    pub(crate) fn begin(&self) -> Result<Begun, Failure> {
        self.reject_folder_options()?;
        self.check_outputs()?;
        let interrupt = self.listen()?;
        let planner = Planner { force: self.force, ..self.arguments.planner(interrupt) };
        let planned = planner.plan(&self.experiment)?;
        if interrupt.is_raised() {
            return Ok(Begun::Planned(planned));
        }
        planned.reject_invalid_starts(&self.experiment)?;
        if self.arguments.execution.dry_run {
            let rerun = planner.rerun(&self.experiment, &planned)?;
            return self.dry_run(&planned, rerun.as_ref(), interrupt).map(Begun::Ended);
        }
        self.say(&describe(&self.experiment, &planned.plan, planned.jobs, &planned.destination()));
        Ok(Begun::Planned(planned))
    }

    /// The error if the disk is too small for the recordings, of which `reserved` bytes belong to other experiments.
    pub(crate) fn disk_shortage(&self, planned: &Planned, reserved: u64) -> Option<Failure> {
        let needed = planned.bytes_at_once().saturating_add(reserved);
        disk_shortage(&planned.plan, needed, self.arguments.output.option_of_folder())
    }

    /// Whether other processes execute the runs.
    pub(crate) fn is_elsewhere(&self) -> bool {
        let arguments = &self.arguments.executor;
        arguments.executor != Executor::Local || arguments.export_commands.is_some()
    }

    /// Exports the runs as commands, or executes them on a cluster.
    pub(crate) fn execute_elsewhere(&self, planned: &Planned) -> Result<Executed, Failure> {
        if self.force && self.arguments.executor.executor != Executor::Local {
            return Err(bad(
                "--force is not supported on a cluster, whose tasks skip finished runs",
            )
            .help("remove the recordings to rerun"));
        }
        let interrupt = self.listen()?;
        self.prepare_folder(planned, interrupt)?;
        if let Some(file) = &self.arguments.executor.export_commands {
            self.export(file, &planned.plan, None)?;
            let executed = self.concluded(planned, &[], Exit::Done);
            return Ok(Executed { destination: None, ..executed });
        }
        match self.arguments.executor.executor.engine() {
            Some(engine) => {
                let mut stored = Recordings::in_folder(&planned.plan.folder);
                let executed = self.execute_on_cluster(engine, planned, &mut stored, None)?;
                self.prune_finished(planned, executed)
            }
            None => Ok(self.concluded(planned, &[], Exit::Done)),
        }
    }

    /// The result without any run.
    pub(crate) fn not_executed(&self, planned: &Planned, exit: Exit) -> Executed {
        Executed { destination: None, ..self.concluded(planned, &[], exit) }
    }

    /// Removes stale files after runs without errors. Only then can the recordings be analyzed.
    fn prune_finished(&self, planned: &Planned, executed: Executed) -> Result<Executed, Failure> {
        if executed.exit != Exit::Done {
            return Ok(Executed { destination: None, ..executed });
        }
        if self.arguments.execution.prune {
            self.prune(&planned.plan)?;
        }
        Ok(executed)
    }

    pub(crate) fn say(&self, text: &str) {
        self.arguments.messages.say(text);
    }

    pub(crate) fn is_task(&self) -> bool {
        self.arguments.executor.only_keys.is_some()
    }

    /// Rejects options that need a folder of recordings when recordings go to object storage.
    fn reject_folder_options(&self) -> Result<(), Failure> {
        let arguments = self.arguments;
        let options = [
            (arguments.execution.prune, "--prune"),
            (arguments.executor.analyze, "--analyze"),
            (arguments.executor.executor != Executor::Local, "--executor"),
        ];
        match options.iter().find(|(is_given, _)| *is_given) {
            Some((_, option)) if arguments.output.is_remote() => {
                Err(bad(format!("{option} needs a local folder, but the recordings go to s3://"))
                    .help(
                        "name a folder with --output DIR; other machines record to s3:// with the commands of --export-commands FILE",
                    ))
            }
            _ => Ok(()),
        }
    }

    /// Rejects destinations that cannot be written, before the first run.
    fn check_outputs(&self) -> Result<(), Failure> {
        match &self.arguments.executor.export_commands {
            Some(file) if !self.arguments.execution.dry_run => {
                output_file::check(file).map_err(|error| unwritten_commands(file, &error))
            }
            _ => Ok(()),
        }
    }

    fn dry_run(
        &self,
        planned: &Planned,
        rerun: Option<&Planned>,
        interrupt: &Interrupt,
    ) -> Result<Executed, Failure> {
        let (manifest, experiment) = (self.manifest, &*self.experiment);
        let checked = PlanReport::new(manifest, experiment, planned, rerun, interrupt);
        stop_if_interrupted(interrupt)?;
        self.say(&checked.text());
        let listed = self.arguments.execution.prune.then(|| self.prune(&planned.plan));
        let exit = match listed {
            Some(Err(failure)) => failure.report(),
            Some(Ok(())) | None => Exit::Done,
        };
        Ok(Executed {
            exit,
            name: self.experiment.name.clone(),
            destination: None,
            is_remote: false,
            keyframes: Vec::new(),
            json: self.arguments.messages.json.then(|| checked.json()),
        })
    }

    /// Removes stale files, or lists them in a dry run.
    fn prune(&self, plan: &Plan) -> Result<(), Failure> {
        let failed = |error: io::Error| {
            let what = format!("cannot prune {}: {error}", shown_path(&plan.folder));
            Failure::new(Exit::Retryable, what)
        };
        let say =
            |file: &Path, what: &str| self.say(&format!("stale, {what}: {}", shown_path(file)));
        let stale = StaleFiles::of(plan).map_err(failed)?;
        if self.arguments.execution.dry_run {
            stale.paths().for_each(|file| say(file, "would be removed"));
            return Ok(());
        }
        let mut report = |file: &Path, removal: Removal| match removal {
            Removal::Removed => say(file, "removed"),
            Removal::InUse => say(file, "not removed, because another process is writing this run"),
        };
        stale.remove(&mut report).map_err(failed)
    }

    pub(crate) fn listen(&self) -> Result<&Interrupt, Failure> {
        if let Some(interrupt) = self.interrupt.get() {
            return Ok(interrupt);
        }
        let interrupt = Interrupt::listen().map_err(|error| {
            Failure::new(Exit::Retryable, format!("cannot listen to Ctrl-C: {error}"))
        })?;
        Ok(self.interrupt.get_or_init(|| interrupt))
    }

    /// Writes what exists before the first run.
    pub(crate) fn prepare_folder(
        &self,
        planned: &Planned,
        interrupt: &Interrupt,
    ) -> Result<(), Failure> {
        let plan = &planned.plan;
        // The side files exist when a task starts, and several tasks run at the same time.
        let experiment = (!self.is_task()).then_some(&*self.experiment);
        prepare_folder(experiment, plan).map_err(|error| {
            let option = self.arguments.output.option_of_folder();
            let what = format!("cannot write to {}: {error}", shown_path(&plan.folder));
            Failure::new(exit::of_output(&error), what)
                .help(format!("make it writable, or choose another folder with {option} DIR; then run the same command again"))
        })?;
        self.upload_all(planned, interrupt);
        Ok(())
    }

    /// Uploads what is recorded, if the recordings go to object storage.
    fn upload_all(&self, planned: &Planned, interrupt: &Interrupt) {
        if let Some(depot) = &planned.depot {
            depot.put_all(&planned.plan, !self.is_task(), &|| interrupt.is_raised());
        }
    }

    /// Uploads and analyzes the recordings, as far as that is requested.
    pub(crate) fn process_recordings(&self, planned: &Planned, interrupt: &Interrupt) {
        self.upload_all(planned, interrupt);
        if self.arguments.executor.analyze && !interrupt.is_raised() {
            self.analyze(&planned.plan);
        }
    }

    /// Prints what the runs of this machine have left, and their errors.
    pub(crate) fn conclude(
        &self,
        planned: &Planned,
        reports: &[(&PlannedRun, Option<local::Report>)],
        interrupt: &Interrupt,
    ) -> Result<Executed, Failure> {
        let plan = &planned.plan;
        let endings: Vec<&RunReport> =
            reports.iter().filter_map(|(_, report)| report.as_ref()?.as_ref().ok()).collect();
        self.say(&summary(plan, &endings));
        let results: Vec<RunResult<'_>> = reports
            .iter()
            .map(|(run, report)| (*run, report.as_ref().map(results::of_run)))
            .collect();
        let exit = results::report_errors(plan, &self.experiment, &results, self.is_task());
        let exit = exit.worst(self.report_uploads(planned));
        if results.is_empty() && exit == Exit::Done {
            self.say(&format!(
                "Nothing to do: all recordings are in {}",
                one_line(&planned.address())
            ));
        }
        let exit = interrupt.exit_code().map_or(exit, Exit::Signal);
        self.prune_finished(planned, self.concluded(planned, &results, exit))
    }

    /// Analyzes the recordings of the plan; an error does not change the exit code of the runs.
    fn analyze(&self, plan: &Plan) {
        let recordings: Vec<PathBuf> = plan
            .runs
            .iter()
            .map(|run| plan.folder.join(run.file_name()))
            .filter(|path| path.exists())
            .collect();
        if recordings.is_empty() {
            return;
        }
        if let Err(why) = kinetoscope_analysis::cli::cache(&recordings) {
            complain(&format!("warning: not all recordings were analyzed: {why}"));
        }
    }

    /// Prints the result of the uploads to object storage, and returns their exit code.
    fn report_uploads(&self, planned: &Planned) -> Exit {
        let Some(depot) = &planned.depot else { return Exit::Done };
        let uploads = depot.report(&planned.plan);
        if uploads.put > 0 {
            let recordings = plural(uploads.put as u64, "recording");
            self.say(&format!("Put {recordings} to {}", depot.address()));
        }
        let exit = exit::of_uploads(&uploads);
        for message in uploads.complaints {
            Failure::of(exit, message).report();
        }
        exit
    }

    fn task_options(&self, rows_per_task: Option<usize>) -> TaskOptions<'_> {
        TaskOptions {
            manifest: self.manifest,
            output: &self.arguments.output,
            overrides: self.overrides,
            analyze: self.arguments.executor.analyze,
            rows_per_task,
            threads: self.arguments.execution.threads,
            checkpoint_every: self.arguments.execution.checkpoint_every,
        }
    }

    pub(crate) fn export(
        &self,
        file: &Path,
        plan: &Plan,
        rows_per_task: Option<usize>,
    ) -> Result<(), Failure> {
        let options = self.task_options(rows_per_task);
        let written = self.arguments.executor.export(file, plan, &options);
        let commands = written.map_err(|error| unwritten_commands(file, &error))?;
        self.say(&format!("Wrote {} to {}", plural(commands as u64, "command"), shown_path(file)));
        Ok(())
    }

    pub(crate) fn execute_on_cluster(
        &self,
        engine: Engine,
        planned: &Planned,
        stored: &mut dyn Results,
        rows_per_task: Option<usize>,
    ) -> Result<Executed, Failure> {
        let (plan, interrupt) = (&planned.plan, self.listen()?);
        let progress = ProgressDisplay::new(plan.to_do().len(), self.arguments.verbosity());
        let failed = |error: io::Error| {
            task_failure(&error, format!("no more tasks could be submitted: {error}"))
        };
        let options = self.task_options(rows_per_task);
        let submission = self.arguments.executor.submission(engine, &options).map_err(failed)?;
        let end = queue::run_all(plan, &submission, stored, interrupt, &progress);
        let end = end.map_err(failed)?;
        progress.close();
        let results: Vec<RunResult<'_>> = end
            .results
            .into_iter()
            .map(|(run, result)| (run, result.map(results::of_task)))
            .collect();
        let mut exit = results::report_errors(plan, &self.experiment, &results, self.is_task());
        if let Some(reasons) = &end.hold_reasons {
            complain(&format!("error: {reasons}"));
            exit = exit.worst(Exit::Retryable);
        }
        let recorded = results.iter().filter(|(_, result)| matches!(result, Some(Ok(_)))).count();
        let left = results.iter().filter(|(_, result)| result.is_none()).count();
        let what = if self.experiment.keeps_only_metrics() { "rows" } else { "recordings" };
        self.say(&format!("{recorded} new {what} in {}", shown_path(&plan.folder)));
        if left > 0 {
            self.say(&format!(
                "{} still on the cluster: run the same command again to wait for them",
                plural(left as u64, "run")
            ));
        }
        let exit = interrupt.exit_code().map_or(exit, Exit::Signal);
        let executed = self.concluded(planned, &results, exit);
        Ok(Executed { destination: None, ..executed })
    }

    fn concluded(&self, planned: &Planned, results: &[RunResult<'_>], exit: Exit) -> Executed {
        let is_json = self.arguments.messages.json;
        Executed {
            exit,
            name: self.experiment.name.clone(),
            destination: Some(planned.address()),
            is_remote: planned.depot.is_some(),
            keyframes: if planned.depot.is_none() { planned.plan.unrestored() } else { Vec::new() },
            json: is_json.then(|| self.json(planned, results, exit)),
        }
    }

    fn json(&self, planned: &Planned, results: &[RunResult<'_>], exit: Exit) -> Json {
        json!({
            "manifest": self.manifest,
            "experiment": self.experiment.name,
            "model": self.experiment.model(),
            "destination": planned.address(),
            "exit_code": exit.code(),
            "runs": results::json(&planned.plan, &self.experiment, results),
        })
    }
}

/// The error of a file of commands that cannot be written.
fn unwritten_commands(file: &Path, error: &io::Error) -> Failure {
    let what = format!("cannot write the commands to {}: {error}", shown_path(file));
    match exit::of_output(error) {
        exit @ Exit::BadInput if error.kind() != io::ErrorKind::InvalidInput => {
            Failure::new(exit, what).help("name another file with --export-commands FILE")
        }
        _ => task_failure(error, what),
    }
}

/// The error of commands for other processes. A word that no shell script can contain is an error in the arguments.
fn task_failure(error: &io::Error, what: String) -> Failure {
    if error.kind() == io::ErrorKind::InvalidInput {
        return bad(what).help("rename the file or folder, or change the value of --set");
    }
    Failure::new(Exit::Retryable, what).help("run the same command again to resume")
}

/// Creates the folder of the recordings with its side files; a task removes the failures of earlier tasks.
fn prepare_folder(experiment: Option<&Experiment>, plan: &Plan) -> io::Result<()> {
    fs::create_dir_all(&plan.folder)?;
    for (run, _) in plan.finished() {
        // A finished run needs no other file, whatever is in the place of its leftovers.
        if let Err(error) = remove_leftovers(&plan.folder, &run.stem()) {
            complain(&format!("warning: a leftover of a finished run stays: {error}"));
        }
    }
    let Some(experiment) = experiment else {
        let mut runs = plan.to_do().into_iter();
        return runs.try_for_each(|run| sidecars::remove_failure(&plan.folder, &run.stem()));
    };
    let files = plan.runs.iter().map(|run| (run.file_name(), run.run_key));
    sidecars::write_experiment(experiment, &plan.folder, files)?;
    sidecars::write_layout(plan)
}
