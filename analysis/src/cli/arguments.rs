//! The command line of `analyze-recordings`.

use crate::export::ExportFormat;
use clap::Parser;
use std::num::NonZeroU32;
use std::path::PathBuf;

/// The exit codes in the help.
const EXIT_CODES: &str = "Exit codes:
  0    done, and all checks hold
  2    bad arguments or checks file
  3    a check failed or its metric is missing, or a metric has moved from the baseline
  5    some input is unreadable; the rest was analyzed
  75   the results can't be written: the same command again may succeed";

/// Derive metrics with standard errors, plots and checks from recordings
///
/// Writes report.html, metrics.json, metrics.csv and one file per plot to the folder of the recordings.
#[derive(Debug, Parser)]
#[command(name = "analyze-recordings", version, after_help = EXIT_CODES)]
pub(super) struct Arguments {
    /// TOML file with additional [[checks]]
    #[arg(long, value_name = "FILE")]
    pub(super) checks: Option<PathBuf>,
    /// Folder for the results [default: that of the recordings]
    #[arg(long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// Additional times of state pictures, in the model's unit [default: start and end]
    #[arg(long, value_name = "TIME,…", value_delimiter = ',', value_parser = finite)]
    pub(super) pictures_at: Vec<f64>,
    /// Also write the frames in formats of other programs, to the folder `export` of the results
    #[arg(long, value_name = "FORM,…", value_delimiter = ',')]
    pub(super) export: Vec<ExportFormat>,
    /// Also write the metrics of all runs as one Parquet table, in folders `export/metrics/KEY=VALUE/` named by the
    /// sweep's coordinates (requires a program built with `--features parquet`)
    #[arg(long)]
    pub(super) table: bool,
    /// Read all recordings, including those unchanged since their last analysis
    #[arg(long)]
    pub(super) fresh: bool,
    /// Only fill the cache folder `.analyzed`, as a task on a cluster does, so that the analysis of the whole sweep
    /// reads no recording again
    #[arg(long, conflicts_with_all = ["checks", "export", "baseline", "junit", "github", "output"])]
    pub(super) remember: bool,
    /// Compare with the metrics.json of an earlier analysis: exit code 3 if a metric differs by more than 4 combined
    /// standard errors
    #[arg(long, value_name = "FILE")]
    pub(super) baseline: Vec<PathBuf>,
    /// Write the check results as JUnit XML
    #[arg(long, value_name = "FILE")]
    pub(super) junit: Option<PathBuf>,
    /// Print failures as annotations of a GitHub workflow
    #[arg(long)]
    pub(super) github: bool,
    #[command(flatten)]
    pub(super) picture: PictureArguments,
    /// Print the reference of all metrics (Markdown)
    #[arg(long, exclusive = true)]
    pub(super) metrics: bool,
    /// Recordings and folders of recordings; also on object storage as s3://BUCKET/PREFIX (requires a program built
    /// with `--features object-storage`)
    #[arg(required_unless_present = "metrics", value_name = "PATH")]
    pub(super) paths: Vec<PathBuf>,
}

/// The arguments of a thumbnail, which replaces an analysis.
#[derive(Debug, clap::Args)]
pub(super) struct PictureArguments {
    /// Only draw one recording as a small picture, a .png or .svg file
    #[arg(long, value_name = "FILE",
          conflicts_with_all = ["checks", "output", "pictures_at", "export", "fresh", "baseline", "junit", "github"])]
    pub(super) thumbnail: Option<PathBuf>,
    /// Number of pictures of an animated thumbnail (.png as APNG), evenly spread over the recording; 1 is its last
    /// frame
    #[arg(long, value_name = "N", default_value = "1", requires = "thumbnail")]
    pub(super) thumbnail_frames: NonZeroU32,
    /// Width of a thumbnail in pixels, from 64 to 4096
    #[arg(long, value_name = "PIXELS", default_value = "480", requires = "thumbnail", value_parser = width)]
    pub(super) thumbnail_width: NonZeroU32,
}

/// Parses a thumbnail's width.
fn width(text: &str) -> Result<NonZeroU32, String> {
    let width = text.parse().ok().filter(|width: &NonZeroU32| (64..=4096).contains(&width.get()));
    width.ok_or_else(|| "must be a number from 64 to 4096".to_owned())
}

/// Parses a finite number.
fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "must be a number".to_owned())
}
