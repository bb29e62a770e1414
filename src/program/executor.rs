//! Options for what executes the runs: this process or a cluster, and the commands that its tasks execute.

use crate::output::{OutputArguments, shell_word};
use crate::program_name::ProgramName;
use clap::{Args, ValueEnum};
use kinetoscope::executor::cluster::queue::SubmissionOptions;
use kinetoscope::executor::cluster::scheduler::Engine;
use kinetoscope::executor::cluster::task::{TaskCommand, dealt, in_intervals};
use kinetoscope::plan::Plan;
use kinetoscope_files::output_file;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

/// What executes the runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Executor {
    /// This process
    #[default]
    Local,
    /// Slurm job arrays; Ctrl-C detaches, and the same command attaches again
    Slurm,
    /// HyperQueue, through the program `hq`
    #[value(name = "hyperqueue")]
    HyperQueue,
}

impl Executor {
    /// The engine that executes tasks; `None` for this process.
    #[must_use]
    pub(crate) fn engine(self) -> Option<Engine> {
        match self {
            Self::Local => None,
            Self::Slurm => Some(Engine::Slurm),
            Self::HyperQueue => Some(Engine::HyperQueue),
        }
    }
}

/// What executes the runs, and which runs.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Cluster")]
pub(crate) struct ExecutorArguments {
    /// Execute the runs with
    #[arg(long, value_enum, default_value = "local")]
    pub executor: Executor,
    /// Number of runs per task of a cluster, at most 1000 [default: chosen for 200 tasks, or for tasks of minutes if only metrics are kept, then without a maximum]
    #[arg(long, value_name = "N", value_parser = at_least_one::<NonZeroUsize>)]
    pub runs_per_task: Option<NonZeroUsize>,
    /// Time limit of a task; unfinished runs resume in the next task [default: three times the expected time on a slow
    /// processor]
    #[arg(long, value_name = "MINUTES", value_parser = at_least_one::<NonZeroU64>)]
    time_limit: Option<NonZeroU64>,
    /// Write the runs to FILE as shell commands, one per line, and stop; each command may be repeated
    #[arg(long, value_name = "FILE", conflicts_with_all = ["executor", "dry_run", "prune", "force"])]
    pub export_commands: Option<PathBuf>,
    /// Execute only the runs with these keys, or from one key to another (KEY-KEY), as a task of a cluster does
    #[arg(long, value_name = "KEY,…", value_delimiter = ',',
          conflicts_with_all = ["executor", "export_commands", "prune"])]
    pub only_keys: Option<Vec<String>>,
    /// Analyze the recordings where they are written; a later analysis does not read them again
    #[arg(long)]
    pub analyze: bool,
    /// Folder that paths of start_from are relative to, for a task with a copy of the manifest [default: the manifest's]
    #[arg(long, value_name = "DIR", requires = "only_keys")]
    pub start_from_dir: Option<PathBuf>,
}

/// Maximum number of threads that compute: more than machines have processors, and few enough to be started in a second.
pub(crate) const MAX_THREADS: usize = 1024;

/// Parses a number of threads or of parallel runs.
pub(crate) fn thread_count(text: &str) -> Result<NonZeroUsize, String> {
    let count = text.parse().ok().filter(|count: &NonZeroUsize| count.get() <= MAX_THREADS);
    count.ok_or_else(|| format!("write a whole number from 1 to {MAX_THREADS}"))
}

/// Parses a count of the command line.
pub(crate) fn at_least_one<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "write a whole number from 1".to_owned())
}

/// The other options that a task needs.
#[derive(Debug)]
pub(crate) struct TaskOptions<'a> {
    /// The manifest.
    pub manifest: &'a Path,
    /// Where recordings are written.
    pub output: &'a OutputArguments,
    /// The overrides of the manifest.
    pub overrides: &'a [String],
    /// Whether tasks analyze what they record.
    pub analyze: bool,
    /// Default number of runs per task if only their metrics are kept.
    pub rows_per_task: Option<usize>,
    /// Threads per run.
    pub threads: Option<NonZeroUsize>,
    /// Time between checkpoints.
    pub checkpoint_every: Duration,
}

impl TaskOptions<'_> {
    /// The command of a task.
    ///
    /// # Errors
    /// A path that cannot be resolved, or a word that no shell script can contain. The output folder must exist.
    fn command(&self) -> io::Result<TaskCommand> {
        let (program, manifest) = (std::env::current_exe()?, fs::canonicalize(self.manifest)?);
        let overrides = self.overrides.iter().map(AsRef::<OsStr>::as_ref);
        for word in [program.as_os_str(), manifest.as_os_str()].into_iter().chain(overrides) {
            shell_word(word)?;
        }
        Ok(TaskCommand {
            // By the name of the file: the path of a program that was called by a link is that of the link's target.
            subcommand: ProgramName::of(&program).run_subcommand(),
            program,
            manifest,
            starts_in: None,
            destination: self.output.words()?,
            overrides: self.overrides.to_vec(),
            analyze: self.analyze,
            threads: self.threads.map_or(1, NonZeroUsize::get),
            is_of_rows: self.rows_per_task.is_some(),
            checkpoint_every_s: self.checkpoint_every.as_secs_f64(),
        })
    }
}

impl ExecutorArguments {
    /// Writes one command per line to FILE, which may be a link, a device or a pipe, each for the number of runs that `--runs-per-task` states
    /// (1; so many that they take minutes, if only their metrics are kept).
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn export(
        &self,
        file: &Path,
        plan: &Plan,
        options: &TaskOptions<'_>,
    ) -> io::Result<usize> {
        let command = options.command()?;
        let (runs, default) = (plan.to_do_by_cost(), options.rows_per_task);
        let runs_per_task = self.runs_per_task.map(NonZeroUsize::get).or(default).unwrap_or(1);
        let tasks = match default {
            Some(_) => in_intervals(&runs, runs_per_task, |_, _| false),
            None => dealt(&runs, runs_per_task),
        };
        let lines: Vec<String> = tasks.iter().map(|task| command.line(&task.keys) + "\n").collect();
        output_file::write(file, lines.concat().as_bytes())?;
        Ok(lines.len())
    }

    /// How the plan is submitted to a cluster.
    ///
    /// # Errors
    /// A path that cannot be resolved. The output folder must exist.
    pub(crate) fn submission(
        &self,
        engine: Engine,
        options: &TaskOptions<'_>,
    ) -> io::Result<SubmissionOptions> {
        Ok(SubmissionOptions {
            engine,
            command: options.command()?,
            runs_per_task: self.runs_per_task.map(NonZeroUsize::get).or(options.rows_per_task),
            time_limit_min: self.time_limit.map(NonZeroU64::get),
        })
    }
}
