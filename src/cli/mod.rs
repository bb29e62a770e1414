//! The command line of `run-experiment`: what is asked, the plan, the runs, what was written and the next command.

pub mod allocator;
mod conclusion;
pub mod disk_space;
pub mod executor;
pub mod exit;
pub mod inspect;
pub mod live;
mod messages;
pub mod output;

use crate::cli::executor::{Distribution, Executor, Rest, at_least_one};
use crate::cli::exit::{EXIT_CODES, Exit};
use crate::cli::inspect::{Evidence, Report};
use crate::cli::live::Watching;
use crate::cli::messages::{describe, name_of};
use crate::cli::output::Destination;
use crate::executor::analyze;
use crate::executor::cluster::scheduler::Engine;
use crate::executor::local::{self, LocalPool};
use crate::executor::progress::{ProgressDisplay, Verbosity};
use crate::interrupt::Interrupt;
use crate::outputs::sidecars;
use crate::outputs::upload::Uploader;
use crate::plan::prune;
use crate::plan::restart_files::StartFiles;
use crate::plan::why::Earlier;
use crate::plan::{Plan, Status};
use crate::run::RunContext;
use crate::run::benchmark::{self, TimingError, time_table};
use clap::Parser;
use conclusion::Conclusion;
use kinetoscope_manifest::{Experiment, Override};
use kinetoscope_recording::file;
use std::fs;
use std::io::{self, IsTerminal, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Run the experiment of a manifest and record every frame, one MCAP file a run.
#[derive(Debug, Parser)]
#[command(name = "run-experiment", version, after_help = EXIT_CODES)]
pub struct Arguments {
    /// The manifest, a TOML file
    #[arg(required_unless_present_any = ["schema", "new", "evidence"], value_name = "MANIFEST")]
    manifest: Option<PathBuf>,
    #[command(flatten)]
    destination: Destination,
    /// Runs side by side [default: one a processor]
    #[arg(long, value_name = "N", value_parser = at_least_one::<NonZeroUsize>)]
    jobs: Option<NonZeroUsize>,
    /// Threads that one run computes with [default: the processors that the runs side by side leave]
    #[arg(long, value_name = "N", value_parser = at_least_one::<NonZeroUsize>)]
    threads: Option<NonZeroUsize>,
    /// Override a key of the manifest, such as model.gas.particles=5000
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Do finished runs again
    #[arg(long)]
    force: bool,
    /// Save each run at least every so many seconds, to go on from there after a kill
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = seconds)]
    checkpoint_every: Duration,
    /// When all runs are done, remove the recordings in the folder that the manifest no longer asks for
    #[arg(long)]
    prune: bool,
    /// Print the plan and stop
    #[arg(long)]
    dry_run: bool,
    /// Say for each run whether it is to be done and why, and stop
    #[arg(long, conflicts_with_all = ["force", "dry_run", "prune"])]
    why: bool,
    /// Time the engine on every run, one at a time, and print a table; nothing is recorded. With --output DIR the table also goes to
    /// DIR/NAME/timing.json, which the report of the recordings there shows
    #[arg(long, conflicts_with_all = ["force", "dry_run", "why", "jobs"])]
    time: bool,
    #[command(flatten)]
    watching: Watching,
    #[command(flatten)]
    distribution: Distribution,
    #[command(flatten)]
    evidence: Evidence,
    /// Say nothing but errors
    #[arg(long, short, conflicts_with = "verbose")]
    quiet: bool,
    /// Say a line for each run that ends, on a terminal too
    #[arg(long, short)]
    verbose: bool,
    /// Print the JSON Schema of manifests, for editors
    #[arg(long, exclusive = true)]
    schema: bool,
    /// Print a commented starter manifest
    #[arg(long, value_name = "MODEL", exclusive = true,
          value_parser = ["dem", "gas", "packing", "orbit"])]
    new: Option<String>,
}

impl Arguments {
    /// Does what the arguments ask.
    #[must_use]
    pub fn execute(&self) -> Exit {
        if self.schema {
            return print(&kinetoscope_manifest::json_schema());
        }
        if let Some(starter) = self.new.as_deref().and_then(kinetoscope_manifest::starter) {
            return print(starter);
        }
        if let Some(report) = self.evidence.execute(self.verbosity()) {
            return self.report(&report);
        }
        match &self.manifest {
            Some(path) => self.run(path),
            None => Exit::BadManifest,
        }
    }

    fn report(&self, report: &Report) -> Exit {
        if !report.text.is_empty() {
            self.say(&report.text);
        }
        match &report.complaint {
            Some(complaint) => fail(report.exit, complaint),
            None => report.exit,
        }
    }

    fn run(&self, path: &Path) -> Exit {
        match self.plan_and_run(path) {
            Ok(exit) => exit,
            Err((exit, message)) => fail(exit, &message),
        }
    }

    fn plan_and_run(&self, path: &Path) -> Result<Exit, (Exit, String)> {
        let bad = |message: String| (Exit::BadManifest, message);
        let experiment = self.read(path).map_err(bad)?;
        if self.time {
            return Ok(timed(&experiment, self.destination.named_folder().map_err(bad)?));
        }
        let depot = self.depot(&experiment).map_err(bad)?;
        let mut plan = self.plan(&experiment).map_err(bad)?;
        if let Some(depot) = &depot {
            depot
                .find(&mut plan, self.force)
                .map_err(|error| (Exit::of_storage(error.is_retryable()), error.to_string()))?;
        }
        if self.why {
            return Ok(explain(&experiment, &plan));
        }
        let refusals: Vec<String> = plan
            .rejected()
            .map(|(run, refusal)| format!("{}: {refusal}", name_of(run, &experiment)))
            .collect();
        if !refusals.is_empty() {
            return Err(bad(refusals.join("\n")));
        }
        let jobs = self.jobs().get().min(plan.to_do().len().max(1));
        let here = plan.folder.display().to_string();
        let place = match &depot {
            None => here,
            Some(depot) => format!("{} by way of {here}", depot.address()),
        };
        self.say(&describe(&experiment, &plan, jobs, &place));
        let at_once = if depot.is_some() { jobs } else { plan.runs.len() };
        let option = self.destination.option_of_folder();
        if let Some(message) = disk_space::shortage(&plan, plan.bytes_at_once(at_once), option) {
            return Err((Exit::Retryable, message));
        }
        if self.force && self.distribution.executor != Executor::Local {
            let message = "--force is for this machine alone: a cluster's task skips what is recorded. Remove the recordings that are to be done again";
            return Err(bad(message.to_owned()));
        }
        if self.dry_run {
            return Ok(if self.prune { self.prune(&plan) } else { Exit::Done });
        }
        Ok(match self.execute_plan(path, &experiment, &plan, depot.as_ref(), jobs) {
            Exit::Done if self.prune => self.prune(&plan),
            exit => exit,
        })
    }

    fn plan(&self, experiment: &Experiment) -> Result<Plan, String> {
        let folder = self.destination.folder().map_err(|error| error.to_string())?;
        let Some(keys) = &self.distribution.only else {
            return Ok(Plan::new(experiment, &folder, self.force));
        };
        Plan::of_keys(experiment, &folder, self.force, keys).map_err(|key| {
            format!(
                "no run has the run key {key}: the manifest or the program has changed since it was given"
            )
        })
    }

    /// Where recordings go that do not stay on this machine.
    fn depot(&self, experiment: &Experiment) -> Result<Option<Uploader>, String> {
        let depot = self.destination.depot(&experiment.name).map_err(|error| error.to_string())?;
        let for_folders_alone = [
            (self.why, "--why"),
            (self.prune, "--prune"),
            (self.distribution.analyze, "--analyze"),
            (self.distribution.executor != Executor::Local, "--executor"),
        ];
        match for_folders_alone.iter().find(|(asked, _)| *asked) {
            Some((_, option)) if depot.is_some() => Err(format!(
                "{option} looks into a folder of recordings, and these go to s3://. Leave it out, or name a folder with --output \
                 DIR; other machines record to s3:// with the commands of --export-commands FILE"
            )),
            _ => Ok(depot),
        }
    }

    /// Removes what is stale, or lists it in a dry run.
    fn prune(&self, plan: &Plan) -> Exit {
        let listed = prune::stale(plan).and_then(|recordings| {
            if !self.dry_run {
                prune::remove(&recordings)?;
            }
            Ok(recordings)
        });
        match listed {
            Ok(recordings) => {
                let verb = if self.dry_run { "would be removed" } else { "removed" };
                for recording in recordings {
                    self.say(&format!("stale, {verb}: {}", recording.display()));
                }
                Exit::Done
            }
            Err(error) => {
                fail(Exit::Retryable, &format!("cannot prune {}: {error}", plan.folder.display()))
            }
        }
    }

    fn read(&self, path: &Path) -> Result<Experiment, String> {
        let source = fs::read_to_string(path).map_err(|error| {
            format!(
                "cannot read the manifest {}: {error}\n\
                 A first one to look at: experiments/first_run.toml; a new one: run-experiment --new gas",
                path.display()
            )
        })?;
        let overrides = self
            .overrides
            .iter()
            .map(|text| match text.split_once('=') {
                Some((key, value)) => {
                    Ok(Override { key: key.trim().to_owned(), value: value.trim().to_owned() })
                }
                None => Err(format!("--set {text}: write KEY=VALUE, such as seed=7")),
            })
            .collect::<Result<Vec<_>, _>>()?;
        let starts = StartFiles::relative_to(self.distribution.starts_in(path));
        let recordings = |name: &str| starts.read(name);
        let origin = path.display().to_string();
        kinetoscope_manifest::parse_with_recordings(&source, &origin, &overrides, &recordings)
            .map_err(|diagnostics| diagnostics.render(has_colors()))
    }

    fn execute_plan(
        &self,
        manifest: &Path,
        experiment: &Experiment,
        plan: &Plan,
        depot: Option<&Uploader>,
        jobs: usize,
    ) -> Exit {
        let interrupt = match Interrupt::listen() {
            Ok(interrupt) => interrupt,
            Err(error) => {
                return fail(Exit::Retryable, &format!("cannot listen to Ctrl-C: {error}"));
            }
        };
        // A task finds the side files there, and others do theirs at the same time.
        let experiment_to_write = self.distribution.only.is_none().then_some(experiment);
        if let Err(error) = prepare_folder(experiment_to_write, plan) {
            return fail(
                Exit::Retryable,
                &format!(
                    "cannot write to {}: {error}\nMake it writable or choose another folder with {} DIR, and run the same command again.",
                    plan.folder.display(),
                    self.destination.option_of_folder()
                ),
            );
        }
        if let Some(depot) = depot {
            depot.put_all(plan, self.distribution.only.is_none(), &|| interrupt.is_raised());
        }
        if let Some(file) = &self.distribution.export_commands {
            let exit = self.export(file, manifest, plan);
            return depot.map_or(exit, |depot| {
                conclusion::delivered(&depot.report(plan), depot, exit, &|text| self.say(text))
            });
        }
        if let Some(engine) = self.distribution.executor.engine() {
            return self.execute_on_cluster(engine, manifest, plan, &interrupt);
        }
        self.execute_here(experiment, plan, depot, jobs, &interrupt)
    }

    fn execute_here(
        &self,
        experiment: &Experiment,
        plan: &Plan,
        depot: Option<&Uploader>,
        jobs: usize,
        interrupt: &Interrupt,
    ) -> Exit {
        let runs = plan.to_do_by_cost();
        let progress = ProgressDisplay::new(runs.len(), self.verbosity());
        let stop = || interrupt.is_raised();
        let live = if runs.is_empty() { Ok(None) } else { self.watching.open(interrupt) };
        let live = match live {
            Ok(live) => live,
            Err((exit, message)) => {
                progress.close();
                return fail(exit, &message);
            }
        };
        if let Some(live) = &live {
            self.say(&self.watching.invitation(live, plan));
        }
        let results = local::run_all(
            &runs,
            &plan.folder,
            self.workforce(jobs),
            RunContext {
                interrupt,
                checkpoint_every: self.checkpoint_every,
                on_frame: &|_, _| {},
                live: live.as_ref(),
            },
            &progress,
            &|run| {
                if let Some(depot) = depot {
                    depot.put_soon(run, &plan.folder, &stop);
                }
            },
        );
        progress.close();
        drop(live);
        if let Some(depot) = depot {
            depot.put_all(plan, self.distribution.only.is_none(), &stop);
        }
        if self.distribution.analyze
            && !interrupt.is_raised()
            && let Err(why) = analyze::remember(plan)
        {
            eprintln!("warning: not all recordings were analyzed: {why}");
        }
        let conclusion = Conclusion {
            experiment,
            plan,
            depot,
            is_task: self.distribution.only.is_some(),
            say: &|text| self.say(text),
        };
        conclusion.of(&results, interrupt.exit_code())
    }

    fn rest<'a>(&'a self, manifest: &'a Path) -> Rest<'a> {
        Rest {
            manifest,
            destination: &self.destination,
            overrides: &self.overrides,
            analyze: self.distribution.analyze,
            threads: self.threads,
            checkpoint_every: self.checkpoint_every,
        }
    }

    fn export(&self, file: &Path, manifest: &Path, plan: &Plan) -> Exit {
        match self.distribution.export(file, plan, &self.rest(manifest)) {
            Ok(commands) => {
                let plural = if commands == 1 { "command" } else { "commands" };
                self.say(&format!("Wrote {commands} {plural} to {}", file.display()));
                Exit::Done
            }
            Err(error) => fail(
                Exit::Retryable,
                &format!("cannot write the commands to {}: {error}", file.display()),
            ),
        }
    }

    fn execute_on_cluster(
        &self,
        engine: Engine,
        manifest: &Path,
        plan: &Plan,
        interrupt: &Interrupt,
    ) -> Exit {
        let rest = self.rest(manifest);
        let progress = ProgressDisplay::new(plan.to_do().len(), self.verbosity());
        let conclusion = match self
            .distribution
            .run_on_cluster(engine, plan, &rest, interrupt, &progress)
        {
            Ok(conclusion) => conclusion,
            Err(error) => {
                let message = format!(
                    "{error}\nNo more tasks could be submitted. The same command goes on from here."
                );
                return fail(Exit::Retryable, &message);
            }
        };
        for complaint in &conclusion.complaints {
            eprintln!("{complaint}");
        }
        self.say(&conclusion.summary);
        match interrupt.exit_code() {
            Some(code) => Exit::Signal(code),
            None => conclusion.exit,
        }
    }

    fn jobs(&self) -> NonZeroUsize {
        self.jobs.or_else(|| std::thread::available_parallelism().ok()).unwrap_or(NonZeroUsize::MIN)
    }

    fn workforce(&self, jobs: usize) -> LocalPool {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let left = self.threads.or_else(|| NonZeroUsize::new(processors / jobs));
        LocalPool {
            jobs: NonZeroUsize::new(jobs).unwrap_or(NonZeroUsize::MIN),
            threads: left.unwrap_or(NonZeroUsize::MIN),
        }
    }

    fn verbosity(&self) -> Verbosity {
        match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (false, true) => Verbosity::Verbose,
            (false, false) => Verbosity::Normal,
        }
    }

    fn say(&self, text: &str) {
        if !self.quiet {
            print(text);
        }
    }
}

/// Times every run and prints the table, which goes to a file as well where a folder is named.
fn timed(experiment: &Experiment, output: Option<&Path>) -> Exit {
    match time_table(experiment) {
        Ok(table) => {
            let told = print(&benchmark::text(&table));
            match output.map(|output| sidecars::write_timing(output, &table)) {
                None => told,
                Some(Ok(path)) => print(&format!("Written to {}", path.display())),
                Some(Err(error)) => {
                    let message =
                        format!("the table can't be written: {error}; free or name another folder");
                    fail(Exit::Retryable, &message)
                }
            }
        }
        Err(TimingError::Setup(error)) => fail(Exit::BadManifest, &error.to_string()),
        Err(TimingError::Fault(fault)) => fail(Exit::RunFailed, &fault.to_string()),
    }
}

/// Says of each run whether it is to be done, and why.
fn explain(experiment: &Experiment, plan: &Plan) -> Exit {
    let earlier = Earlier::in_folder(&plan.folder);
    for run in &plan.runs {
        print(&format!("{}: {}", name_of(run, experiment), earlier.reason(run, &plan.folder)));
    }
    if plan.rejected().next().is_some() { Exit::BadManifest } else { Exit::Done }
}

fn prepare_folder(experiment: Option<&Experiment>, plan: &Plan) -> io::Result<()> {
    fs::create_dir_all(&plan.folder)?;
    for run in plan.runs.iter().filter(|run| matches!(run.status, Status::Done(_))) {
        file::remove_leftovers(&plan.folder, &run.stem).map_err(io::Error::other)?;
    }
    let Some(experiment) = experiment else {
        // A task takes back what an earlier one said of its runs.
        return plan
            .to_do()
            .iter()
            .try_for_each(|run| sidecars::remove_failure(&plan.folder, &run.stem));
    };
    sidecars::write_experiment(experiment, plan)?;
    sidecars::write_layout(plan)
}

/// A closed pipe (`| head`) is no error of ours.
fn print(text: &str) -> Exit {
    let _ = writeln!(io::stdout(), "{text}");
    Exit::Done
}

fn fail(exit: Exit, message: &str) -> Exit {
    eprintln!("{message}");
    exit
}

/// Whether errors are colored: on a terminal, unless its user asks for none.
fn has_colors() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().map_err(|_| "write a number of seconds, such as 5".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}
