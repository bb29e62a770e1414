//! The command lines of `analyze-recordings` and `kinetoscope analyze`.

use crate::export::ExportFormat;
use crate::report::text::Extent;
use kinetoscope_console::StandardOutput;
use std::path::PathBuf;

/// The exit codes as the help shows them.
pub const EXIT_CODES: &str = "Exit codes:
  0    done, and all checks pass
  2    bad arguments, checks file or baseline
  3    a run failed, is unfinished, or completed where its
       manifest expects a fault; a check failed or its metric
       is missing, or a metric or a key has changed from the
       baseline
  5    some input is unreadable; the rest was analyzed
  70   an internal error, or not enough memory
  75   a disk failed under an input, or the results cannot
       be written: the same command may succeed later";

/// Compute metrics with standard errors, plots and checks from recordings.
#[derive(Debug, clap::Args)]
pub struct AnalyzeArguments {
    /// Recordings, folders of recordings, and manifests whose recordings are in `recordings` [default: recordings]; also on object
    /// storage as s3://BUCKET/PREFIX, in a program built with `--features object-storage`
    #[arg(value_name = "PATH")]
    pub(super) paths: Vec<PathBuf>,
    /// Print the reference of all metrics (Markdown), or the metrics of a model and with words, such as `gas pressure`, and stop
    #[arg(long, exclusive = true, num_args = 0.., value_name = "WORD")]
    pub(super) list_metrics: Option<Vec<String>>,
    /// Read all recordings, including those that have not changed since their last analysis
    #[arg(long)]
    pub(super) no_cache: bool,
    /// Write the cache `.analysis-cache` only, as a task of a cluster does, so that a later analysis reads no recording again
    #[arg(long, conflicts_with_all = ["checks", "export", "baseline", "junit", "github_annotations", "output", "json"])]
    pub(super) cache_only: bool,
    /// TOML file with [[checks]] in addition to those of the experiment
    #[arg(long, value_name = "FILE", help_heading = "Checks")]
    pub(super) checks: Option<PathBuf>,
    /// Compare with the metrics.json of an earlier analysis, run by run: same run, equal values; other versions, equal within
    /// rounding; another seed, no significant difference; another key, exit code 3
    #[arg(long, value_name = "FILE", help_heading = "Checks")]
    pub(super) baseline: Vec<PathBuf>,
    /// Compare with the baseline as for another seed although this key of the manifest differs; can be repeated
    #[arg(long, value_name = "KEY", requires = "baseline", help_heading = "Checks")]
    pub(super) allow_changed: Vec<String>,
    /// Write the results of the checks as JUnit XML
    #[arg(long, value_name = "FILE", help_heading = "Checks")]
    pub(super) junit: Option<PathBuf>,
    /// Print failed checks as annotations of a GitHub workflow
    #[arg(long, help_heading = "Checks")]
    pub(super) github_annotations: bool,
    /// Folder for the results [default: that of the recordings]
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub(super) output: Option<PathBuf>,
    /// Draw the state at these times as well, in the model's unit, in addition to start and end
    #[arg(long, value_name = "TIME,…", value_delimiter = ',', value_parser = finite, help_heading = "Output")]
    pub(super) snapshots_at: Vec<f64>,
    /// Maximum size of all replays in report.html, MB; of longer runs, fewer frames are shown
    #[arg(long, value_name = "MB", default_value = "3", value_parser = megabytes, help_heading = "Output")]
    pub(super) replay_budget: usize,
    /// Write report.html without replays
    #[arg(long, conflicts_with = "replay_budget", help_heading = "Output")]
    pub(super) no_replay: bool,
    /// Write report.html without the engine that repeats its runs in the reader's browser
    #[arg(long, help_heading = "Output")]
    pub(super) no_engine: bool,
    /// Put that engine, if the program carries one, into report.html, about 1 MB, instead of a file next to it
    #[arg(long, conflicts_with = "no_engine", help_heading = "Output")]
    pub(super) single_file: bool,
    /// Open the report in the browser; of several experiments, the page that lists them
    #[arg(long, conflicts_with = "cache_only", help_heading = "Output")]
    pub(super) open: bool,
    /// Write the frames in the formats of other programs as well, to the folder `export` of the results
    #[arg(long, value_name = "FORMAT,…", value_delimiter = ',', help_heading = "Output")]
    pub(super) export: Vec<ExportFormat>,
    /// Write the metrics of all runs as one Parquet table as well, in folders `export/metrics/KEY=VALUE/` named by the
    /// coordinates of the sweep
    #[arg(long, help_heading = "Output")]
    pub(super) metrics_table: bool,
    /// Print every metric, note and check, not only the answer and the checked numbers
    #[arg(long, conflicts_with_all = ["quiet", "json"], help_heading = "Messages")]
    pub(super) all: bool,
    /// Print errors only
    #[arg(long, short, help_heading = "Messages")]
    pub(super) quiet: bool,
    /// Print metrics and checks as JSON
    #[arg(long, conflicts_with = "github_annotations", help_heading = "Messages")]
    pub(super) json: bool,
    #[arg(skip)]
    pub(super) standard_output: StandardOutput,
}

/// Size of the replays of a page unless `--replay-budget` gives another, bytes.
pub(super) const REPLAY_BYTES: usize = 3_000_000;

impl AnalyzeArguments {
    /// How much is printed of each experiment.
    pub(super) fn extent(&self) -> Extent {
        if self.all { Extent::Whole } else { Extent::Brief }
    }

    /// Maximum size of the replays of a page; `None` for a page without.
    pub(super) fn replay_bytes(&self) -> Option<usize> {
        (!self.no_replay).then_some(self.replay_budget)
    }
}

/// A number of megabytes from 0.01 to 100, in bytes.
fn megabytes(text: &str) -> Result<usize, String> {
    let number = text.trim().parse().ok().filter(|number| (0.01..=100.0).contains(number));
    let bytes = number.map(|number: f64| libm::round(number * 1e6) as usize);
    bytes.ok_or_else(|| "must be a number from 0.01 to 100".to_owned())
}

/// A finite number.
fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "must be a number".to_owned())
}
