//! Arguments of `run`.

use crate::executor::{ExecutorArguments, thread_count};
use crate::manifests::ManifestArguments;
use crate::messages::progress::Verbosity;
use crate::messages::result_arguments::ResultArguments;
use crate::output::OutputArguments;
use crate::planning::planner::Planner;
use crate::running::live::LiveArguments;
use clap::Args;
use kinetoscope::interrupt::Interrupt;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Run the experiments of manifests: one MCAP recording per run, with every frame.
#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    /// Manifests (TOML files), or folders of manifests
    #[arg(required = true, value_name = "MANIFEST")]
    pub(crate) manifests: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) manifest: ManifestArguments,
    #[command(flatten)]
    pub(crate) output: OutputArguments,
    #[command(flatten)]
    pub(crate) execution: ExecutionArguments,
    #[command(flatten)]
    pub(crate) executor: ExecutorArguments,
    #[command(flatten)]
    pub(crate) live: LiveArguments,
    #[command(flatten)]
    pub(crate) messages: ResultArguments,
    /// Print one line per finished run, on a terminal as well
    #[arg(long, short, conflicts_with = "quiet", help_heading = "Messages")]
    verbose: bool,
}

/// Which runs are executed on this machine, and how many at the same time.
#[derive(Debug, Args)]
#[command(next_help_heading = "Execution")]
pub(crate) struct ExecutionArguments {
    /// Number of runs to execute in parallel [default: number of CPUs]
    #[arg(long, value_name = "N", value_parser = thread_count)]
    pub(crate) jobs: Option<NonZeroUsize>,
    /// Number of threads per run [default: number of CPUs divided by the number of parallel runs]
    #[arg(long, value_name = "N", value_parser = thread_count)]
    pub(crate) threads: Option<NonZeroUsize>,
    /// Rerun finished runs
    #[arg(long)]
    pub(crate) force: bool,
    /// Time between checkpoints of a run, which resumes from the last one after a kill
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = seconds)]
    pub(crate) checkpoint_every: Duration,
    /// After all runs, remove recordings and partial files that the manifest no longer describes, plots that show them, and
    /// temporary files that killed programs left a day ago
    #[arg(long)]
    pub(crate) prune: bool,
    /// Print what `kinetoscope check` prints, and stop
    #[arg(long)]
    pub(crate) dry_run: bool,
}

/// The default of `--checkpoint-every`.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(5);

impl RunArguments {
    /// Executes the runs of a manifest on this machine, below a folder, and prints errors only.
    pub(crate) fn of_manifest(
        manifest: &Path,
        folder: &Path,
        jobs: Option<NonZeroUsize>,
        threads: Option<NonZeroUsize>,
    ) -> Self {
        Self {
            manifests: vec![manifest.to_owned()],
            manifest: ManifestArguments::default(),
            output: OutputArguments::below(folder),
            execution: ExecutionArguments {
                jobs,
                threads,
                force: false,
                checkpoint_every: CHECKPOINT_EVERY,
                prune: false,
                dry_run: false,
            },
            executor: ExecutorArguments::default(),
            live: LiveArguments::default(),
            messages: ResultArguments::errors_only(),
            verbose: false,
        }
    }

    pub(crate) fn verbosity(&self) -> Verbosity {
        match (self.messages.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (false, true) => Verbosity::Verbose,
            (false, false) => Verbosity::Normal,
        }
    }

    pub(crate) fn planner<'a>(&'a self, interrupt: &'a Interrupt) -> Planner<'a> {
        Planner {
            output: &self.output,
            keys: self.executor.only_keys.as_deref(),
            force: self.execution.force,
            jobs: self.execution.jobs,
            is_outline: self.execution.dry_run,
            interrupt,
            verbosity: self.verbosity(),
        }
    }
}

/// Parses a duration of the command line.
fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().map_err(|_| "write a number of seconds, such as 5".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Command {
        #[command(flatten)]
        run: RunArguments,
    }

    /// Defaults of options are texts for clap and values for callers in this program.
    #[test]
    fn arguments_of_a_manifest_are_those_of_the_command_line() {
        let words = ["run", "--quiet", "--output", "folder", "--jobs", "2", "exp.toml"];
        let parsed = Command::try_parse_from(words).unwrap().run;
        let jobs = NonZeroUsize::new(2);
        let given =
            RunArguments::of_manifest(Path::new("exp.toml"), Path::new("folder"), jobs, None);
        assert_eq!(format!("{given:?}"), format!("{parsed:?}"));
    }
}
