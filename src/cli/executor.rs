//! What the command line says of other machines: who does the runs, and which of them this process does.

use crate::cli::exit::Exit;
use crate::cli::output::Destination;
use crate::executor::cluster::queue::{self, SubmissionOptions};
use crate::executor::cluster::scheduler::Engine;
use crate::executor::cluster::task::{TaskCommand, dealt, keys};
use crate::executor::progress::ProgressDisplay;
use crate::interrupt::Interrupt;
use crate::outputs::sidecars::{self, Failure};
use crate::plan::{Plan, PlannedRun};
use clap::{Args, ValueEnum};
use kinetoscope_recording::atomic_file;
use kinetoscope_recording::recorder::Outcome;
use std::fs;
use std::io;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

/// Who does the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Executor {
    /// This process
    Local,
    /// Slurm: job arrays; Ctrl-C detaches, and the same command re-attaches
    Slurm,
    /// HyperQueue, through the site's `hq`: as Slurm
    #[value(name = "hyperqueue")]
    HyperQueue,
}

impl Executor {
    /// The engine that does tasks; `None` of this process.
    #[must_use]
    pub fn engine(self) -> Option<Engine> {
        match self {
            Self::Local => None,
            Self::Slurm => Some(Engine::Slurm),
            Self::HyperQueue => Some(Engine::HyperQueue),
        }
    }
}

/// Who does the runs, and which.
#[derive(Debug, Args)]
pub struct Distribution {
    /// Who does the runs
    #[arg(long, value_enum, default_value = "local")]
    pub executor: Executor,
    /// Runs that a task of a cluster does one after the other, at most 1000 [default: so many that there are 200 tasks]
    #[arg(long, value_name = "N", value_parser = at_least_one::<NonZeroUsize>)]
    runs_per_task: Option<NonZeroUsize>,
    /// Minutes that a task of a cluster may take; what is not done then goes on in the next [default: three times
    /// what the plan expects of a slow processor]
    #[arg(long, value_name = "MINUTES", value_parser = at_least_one::<NonZeroU64>)]
    time_limit: Option<NonZeroU64>,
    /// Write the runs to FILE as shell commands, one a line, each of which may be run again; and stop
    #[arg(long, value_name = "FILE", conflicts_with_all = ["executor", "dry_run", "prune", "force"])]
    pub export_commands: Option<PathBuf>,
    /// Do only the runs with these run keys: what a task of a cluster is asked
    #[arg(long, value_name = "KEY,…", value_delimiter = ',',
          conflicts_with_all = ["executor", "export_commands", "why", "prune"])]
    pub only: Option<Vec<String>>,
    /// Analyze recordings where they are made: analyze-recordings reads none of them again
    #[arg(long, conflicts_with_all = ["why", "time"])]
    pub analyze: bool,
    /// Folder that the paths of start_from are relative to: what a task of a cluster is told, whose manifest is a copy
    /// [default: the manifest's]
    #[arg(long, value_name = "DIR", requires = "only")]
    starts_in: Option<PathBuf>,
}

/// A count of the command line.
pub(crate) fn at_least_one<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "write a whole number from 1".to_owned())
}

/// What of the rest of the command line a task has to know.
#[derive(Debug)]
pub struct Rest<'a> {
    /// The manifest.
    pub manifest: &'a Path,
    /// Where recordings go.
    pub destination: &'a Destination,
    /// The overrides of the manifest.
    pub overrides: &'a [String],
    /// Whether tasks analyze what they record.
    pub analyze: bool,
    /// Threads of a run.
    pub threads: Option<NonZeroUsize>,
    /// Time between checkpoints.
    pub checkpoint_every: Duration,
}

impl Rest<'_> {
    /// # Errors
    /// A path that can't be followed. The output folder must be there.
    fn command(&self) -> io::Result<TaskCommand> {
        Ok(TaskCommand {
            program: std::env::current_exe()?,
            manifest: fs::canonicalize(self.manifest)?,
            starts_in: None,
            destination: self.destination.words()?,
            overrides: self.overrides.to_vec(),
            analyze: self.analyze,
            threads: self.threads.map_or(1, NonZeroUsize::get),
            checkpoint_every_s: self.checkpoint_every.as_secs_f64(),
        })
    }
}

impl Distribution {
    /// The folder that the recordings are relative to that a manifest names.
    #[must_use]
    pub fn starts_in<'a>(&'a self, manifest: &'a Path) -> &'a Path {
        let own = manifest.parent().unwrap_or(Path::new(""));
        self.starts_in.as_deref().unwrap_or(own)
    }

    /// Writes one command a line to FILE, of as many runs each as `--runs-per-task` says (one).
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn export(&self, file: &Path, plan: &Plan, rest: &Rest<'_>) -> io::Result<usize> {
        let command = rest.command()?;
        let tasks = dealt(&plan.to_do_by_cost(), self.runs_per_task.map_or(1, NonZeroUsize::get));
        let lines: Vec<String> =
            tasks.iter().map(|runs| command.line(&keys(runs)) + "\n").collect();
        atomic_file::replace(file, lines.concat().as_bytes())?;
        Ok(lines.len())
    }

    /// Does the plan's runs on the cluster and says how it ended.
    ///
    /// # Errors
    /// As [`queue::run_all`].
    pub fn run_on_cluster(
        &self,
        engine: Engine,
        plan: &Plan,
        rest: &Rest<'_>,
        interrupt: &Interrupt,
        progress: &ProgressDisplay,
    ) -> io::Result<Conclusion> {
        let errand = SubmissionOptions {
            engine,
            command: rest.command()?,
            runs_per_task: self.runs_per_task.map(NonZeroUsize::get),
            time_limit_min: self.time_limit.map(NonZeroU64::get),
        };
        let end = queue::run_all(plan, &errand, interrupt, progress)?;
        progress.close();
        Ok(concluded(end, plan))
    }
}

/// How a plan ended that others did.
#[derive(Debug)]
pub struct Conclusion {
    /// A line for each run that did not end well, and for what the cluster will not start.
    pub complaints: Vec<String>,
    /// What is there.
    pub summary: String,
    /// The exit code, but for a signal.
    pub exit: Exit,
}

fn concluded(end: queue::End<'_>, plan: &Plan) -> Conclusion {
    let mut conclusion =
        Conclusion { complaints: Vec::new(), summary: String::new(), exit: Exit::Done };
    let (mut recorded, mut left) = (0, 0);
    for (run, end) in &end.results {
        let (complaint, class) = match end {
            None => {
                left += 1;
                continue;
            }
            Some(Ok(Outcome::Fault(fault))) => {
                recorded += 1;
                (format!("ended in a fault: {fault}"), Exit::RunFailed)
            }
            Some(Ok(_)) => {
                recorded += 1;
                continue;
            }
            Some(Err(Failure { is_retryable, message })) => {
                let class = if *is_retryable { Exit::Retryable } else { Exit::RunFailed };
                (message.clone(), class)
            }
        };
        conclusion.complaints.push(format!("{}: {complaint}", run.stem));
        if conclusion.exit != Exit::RunFailed {
            conclusion.exit = class;
        }
    }
    if let Some(hold_reasons) = end.hold_reasons {
        conclusion.complaints.push(hold_reasons);
        if conclusion.exit != Exit::RunFailed {
            conclusion.exit = Exit::Retryable;
        }
    }
    conclusion.summary = format!("{recorded} new recordings in {}", plan.folder.display());
    if left > 0 {
        conclusion.summary += &format!(
            "\n{left} runs are left to the cluster: the same command waits for them again"
        );
    }
    conclusion
}

/// A task leaves word of a run that has no recording, for who gave it the task.
pub fn report_failure(folder: &Path, run: &PlannedRun, is_retryable: bool, message: &str) {
    let failure = Failure { is_retryable, message: message.to_owned() };
    if let Err(error) = sidecars::write_failure(folder, &run.stem, &failure) {
        eprintln!("warning: no report of the failure of {}: {error}", run.stem);
    }
}
