//! `run`: executes the experiments of one or several manifests, each after those that it starts from.

mod arguments;
mod experiment;
mod journal;
mod live;
mod metrics_only;
mod next_command;
mod results;
mod shards;
mod shared_pool;
pub(crate) mod simulate;
mod sweep_rows;
mod task_of_rows;

use crate::allocator::start_threads_for;
use crate::manifests::pipeline;
use crate::manifests::step::Step;
use crate::manifests::{ManifestReader, NoRecording, canonical, expand};
use crate::messages::{Failure, bad, plural, word};
use crate::planning::plan_report;
use crate::planning::planner::parallel_runs;
use crate::program_name::ProgramName;
pub(crate) use crate::running::arguments::RunArguments;
use crate::running::experiment::{Begun, Executed, Execution};
use crate::running::shared_pool::{Member, SharedPool};
use kinetoscope::interrupt::Interrupt;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use kinetoscope_manifest::{Experiment, Override};
use serde_json::json;
use std::cell::OnceCell;
use std::path::{Path, PathBuf};

/// An experiment that was read before the first run, or the errors in its manifest.
enum Reading {
    Read(Box<Experiment>),
    /// It starts from an experiment that has no recording yet.
    Pending,
}

impl Reading {
    fn runs(&self) -> usize {
        match self {
            Self::Read(experiment) => experiment.runs.len(),
            Self::Pending => 1,
        }
    }
}

impl RunArguments {
    /// Executes the runs.
    #[must_use]
    pub(crate) fn execute(&self, program: ProgramName) -> Exit {
        self.execute_until(program, OnceCell::new())
    }

    /// The same by a command that listens to signals already, if the cell has its interrupt.
    pub(crate) fn execute_until(
        &self,
        program: ProgramName,
        interrupt: OnceCell<Interrupt>,
    ) -> Exit {
        let failed = |failure: Failure| self.messages.failed(&failure);
        self.messages.concluded(self.run_all(program, &interrupt).unwrap_or_else(failed))
    }

    fn run_all(
        &self,
        program: ProgramName,
        interrupt: &OnceCell<Interrupt>,
    ) -> Result<Exit, Failure> {
        let overrides = self.manifest.overrides()?;
        let manifests = expand(&self.manifests)?;
        self.reject_several(&manifests)?;
        let output = self.output.folder()?;
        let start_from_dir = self.executor.start_from_dir.as_deref();
        let reader = ManifestReader::new(output, start_from_dir);
        let steps = pipeline::order(&manifests, &overrides, &reader)?;
        let experiments = self.read_all(&steps, &overrides, &reader)?;
        let runs = experiments.iter().map(Reading::runs).sum();
        start_threads_for(parallel_runs(self.execution.jobs, runs))?;
        let mut session = Session {
            arguments: self,
            program,
            reader: &reader,
            overrides: &overrides,
            interrupt,
            waiting: SharedPool::new(self),
            executed: Vec::new(),
            exit: Exit::Done,
        };
        for (step, reading) in steps.iter().zip(experiments) {
            if !session.is_interrupted() {
                session.step(step, reading)?;
            }
        }
        session.execute_waiting();
        session.conclude();
        Ok(session.exit)
    }

    /// Rejects several manifests with an option that belongs to one.
    fn reject_several(&self, manifests: &[PathBuf]) -> Result<(), Failure> {
        let single = [
            (self.executor.export_commands.is_some(), "--export-commands"),
            (self.executor.only_keys.is_some(), "--only-keys"),
        ];
        match single.iter().find(|(is_given, _)| *is_given) {
            Some((_, option)) if manifests.len() > 1 => {
                let given = plural(manifests.len() as u64, "manifest");
                let what = format!("{option} takes one manifest, found {given}");
                Err(bad(what).help("call the program once for each manifest"))
            }
            _ => Ok(()),
        }
    }

    /// Reads all manifests before the first run, so that an error in any of them stops the command.
    fn read_all(
        &self,
        steps: &[Step],
        overrides: &[Override],
        reader: &ManifestReader<'_>,
    ) -> Result<Vec<Reading>, Failure> {
        let (mut readings, mut errors) = (Vec::new(), Vec::new());
        let mut names: Vec<(String, &Path)> = Vec::new();
        for step in steps {
            if reader.missing_start(step).is_some() {
                readings.push(Reading::Pending);
                continue;
            }
            match reader.read(&step.manifest, step.overrides(overrides)) {
                Ok(experiment) => {
                    if let Some((name, other)) =
                        names.iter().find(|(name, _)| *name == experiment.name)
                    {
                        let what = format!(
                            "{} and {} have the same name {name:?}, and so the same folder",
                            shown_path(other),
                            shown_path(&step.manifest)
                        );
                        errors.push(bad(what).help("set `name` in one of them"));
                    }
                    errors.extend(several_starts(step, steps, &experiment));
                    names.push((experiment.name.clone(), &step.manifest));
                    readings.push(Reading::Read(Box::new(experiment)));
                }
                Err(failure) => errors.push(failure),
            }
        }
        if errors.is_empty() {
            return Ok(readings);
        }
        Err(Failure::together(&errors))
    }
}

/// The error if another manifest starts from an experiment with several runs.
fn several_starts(step: &Step, steps: &[Step], experiment: &Experiment) -> Option<Failure> {
    let is_start = |other: &&Step| {
        other.starts_from.iter().any(|start| canonical(start) == canonical(&step.manifest))
    };
    let other = steps.iter().find(is_start).filter(|_| experiment.runs.len() != 1)?;
    let what = format!(
        "{} starts from {}, which has {} runs; must have 1",
        shown_path(&other.manifest),
        shown_path(&step.manifest),
        experiment.runs.len()
    );
    Some(bad(what).help("name the recording (*.mcap) of one of its runs"))
}

/// One call of the program, with what has been executed so far.
struct Session<'a> {
    arguments: &'a RunArguments,
    program: ProgramName,
    reader: &'a ManifestReader<'a>,
    overrides: &'a [Override],
    interrupt: &'a OnceCell<Interrupt>,
    /// Experiments that are planned.
    waiting: SharedPool<'a>,
    executed: Vec<Executed>,
    /// The worst exit code so far.
    exit: Exit,
}

impl<'a> Session<'a> {
    /// Plans one manifest; its runs are executed together with those of the next ones, if possible. The failure of one does not stop the
    /// others.
    fn step(&mut self, step: &'a Step, reading: Reading) -> Result<(), Failure> {
        let is_dry = self.arguments.execution.dry_run;
        let experiment = match reading {
            Reading::Read(experiment) => experiment,
            Reading::Pending if is_dry => {
                let why = self.reader.missing_start(step);
                if let Some(text) =
                    why.map(|why| plan_report::not_planned(step, why)).transpose()?
                {
                    self.arguments.messages.say(&text);
                }
                return Ok(());
            }
            Reading::Pending => {
                self.execute_waiting();
                if self.is_interrupted() {
                    return Ok(());
                }
                if let Some(why) = self.reader.missing_start(step) {
                    let failure = self.not_started(step, &why);
                    self.take(Err(failure));
                    return Ok(());
                }
                match self.reader.read(&step.manifest, step.overrides(self.overrides)) {
                    Ok(experiment) => Box::new(experiment),
                    Err(failure) => {
                        self.take(Err(failure));
                        return Ok(());
                    }
                }
            }
        };
        let is_task = self.arguments.executor.only_keys.is_some();
        if !step.is_named && (is_task || self.reader.recording_of(&step.manifest).is_ok()) {
            return Ok(());
        }
        self.plan(Execution {
            arguments: self.arguments,
            manifest: &step.manifest,
            overrides: if step.is_named { &self.arguments.manifest.set } else { &[] },
            force: step.is_named && self.arguments.execution.force,
            experiment,
            interrupt: self.interrupt,
        });
        Ok(())
    }

    fn plan(&mut self, execution: Execution<'a>) {
        if execution.experiment.keeps_only_metrics() && !self.arguments.execution.dry_run {
            self.execute_waiting();
            if !self.is_interrupted() {
                self.take(match execution.is_task() {
                    true => execution.execute_task_of_rows(),
                    false => execution.execute_for_metrics(),
                });
            }
            return;
        }
        let planned = match execution.begin() {
            Ok(Begun::Planned(planned)) => planned,
            Ok(Begun::Ended(executed)) => return self.take(Ok(executed)),
            Err(failure) => return self.take(Err(failure)),
        };
        let member = Member { execution, planned };
        if !self.has_signal() && !self.waiting.has_room_for(&member) {
            self.execute_waiting();
        }
        if self.is_interrupted() {
            return;
        }
        let Member { execution, planned } = &member;
        if !self.has_signal() {
            if let Some(failure) = execution.disk_shortage(planned, 0) {
                return self.take(Err(failure));
            }
            if execution.is_elsewhere() {
                let executed = execution.execute_elsewhere(planned);
                self.reader.forget_missing();
                return self.take(executed);
            }
        }
        if !self.waiting.add(member) || self.has_signal() {
            self.execute_waiting();
        }
    }

    /// Whether a signal has arrived.
    fn has_signal(&self) -> bool {
        self.interrupt.get().is_some_and(Interrupt::is_raised)
    }

    /// Whether a signal has ended an experiment.
    fn is_interrupted(&self) -> bool {
        matches!(self.exit, Exit::Signal(_))
    }

    fn execute_waiting(&mut self) {
        let (waiting, interrupt) = (self.waiting.take(), self.interrupt.get());
        if let Some(interrupt) = interrupt {
            waiting.execute(interrupt, |executed| self.take(executed));
            self.reader.forget_missing();
        }
    }

    /// Keeps the result of an experiment, or prints its error.
    fn take(&mut self, executed: Result<Executed, Failure>) {
        self.exit = self.exit.worst(match executed {
            Ok(executed) => {
                let exit = executed.exit;
                self.executed.push(executed);
                exit
            }
            Err(failure) => failure.report(),
        });
    }

    /// The error of a step whose start has no recording. The run of the start has reported its own error.
    fn not_started(&self, step: &Step, why: &NoRecording) -> Failure {
        let what = format!("{} was not started: {why}", shown_path(&step.manifest));
        match (why, &self.arguments.executor.export_commands) {
            (NoRecording::Failed(_), _) => {
                Failure::new(Exit::RunFailed, what).help("change the manifest that it starts from")
            }
            (NoRecording::Missing(_), Some(file)) => Failure::new(Exit::Retryable, what).help(
                format!("execute the commands of {}, then repeat this one", shown_path(file)),
            ),
            (NoRecording::Missing(_), None) => Failure::new(Exit::Retryable, what)
                .help("repeat the command when that run can be finished"),
            (NoRecording::Invalid(_), _) => {
                bad(what).help("correct the manifest that it starts from")
            }
        }
    }

    /// Prints the next command, or the summary as JSON.
    fn conclude(&self) {
        let (exit, messages) = (self.exit, &self.arguments.messages);
        if messages.json {
            let experiments: Vec<_> =
                self.executed.iter().filter_map(|executed| executed.json.as_ref()).collect();
            messages.print_json(&json!({ "exit_code": exit.code(), "experiments": experiments }));
            return;
        }
        let destinations: Vec<String> =
            self.executed.iter().filter_map(|executed| executed.destination.clone()).collect();
        if exit == Exit::Done && !destinations.is_empty() {
            let is_remote = self.executed.iter().any(|executed| executed.is_remote);
            let executed = self.executed.iter().filter(|executed| executed.destination.is_some());
            let keyframes: Vec<PathBuf> =
                executed.flat_map(|executed| executed.keyframes.clone()).collect();
            let mut next = self.program.next_command(&keyframes, &destinations, is_remote);
            if let ([executed], true) = (self.executed.as_slice(), is_remote) {
                let folder = Path::new("recordings").join(&executed.name);
                next += &format!(" --output {}", word(&folder.to_string_lossy()));
            }
            messages.say_commands(&next);
        }
    }
}
