//! The command line of `analyze-recordings`, and its exit codes.

use crate::checks::baseline::Baseline;
use crate::checks::ci_formats;
use crate::export::{self, ExportFormat};
use crate::input;
use crate::input::{InvalidPath, RecordingFolder};
use crate::report::files;
use crate::report::table::{Style, Terminal};
use crate::report::{self, AnalysisOptions, AnalysisReport, analyze};
use crate::run::cache::AnalysisCache;
use crate::thumbnail::{ThumbnailError, ThumbnailFormat, ThumbnailOptions, thumbnail};
use crate::write_file::{self, WriteError};
use clap::Parser;
use kinetoscope_manifest::{Check, parse_checks};
use kinetoscope_recording::error::ReadError;
use std::io::{IsTerminal, Write};
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

/// The exit codes as the help shows them.
const EXIT_CODES: &str = "Exit codes:
  0    done, and all checks hold
  2    bad arguments or checks file
  3    a check failed or its metric is missing, or a metric has moved from the baseline
  5    some input is unreadable; the rest was analyzed
  75   the results can't be written: the same command again may succeed";

/// Derive numbers with errors, plots and verdicts from recordings alone
///
/// Writes report.html, metrics.json, metrics.csv and a file a plot beside the recordings.
#[derive(Debug, Parser)]
#[command(name = "analyze-recordings", version, after_help = EXIT_CODES)]
struct Arguments {
    /// TOML file with [[checks]], judged beside those of the experiment
    #[arg(long, value_name = "FILE")]
    checks: Option<PathBuf>,
    /// Folder for the results [default: that of the recordings]
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Draw the state at these times as well, in the model's unit, beside start and end
    #[arg(long, value_name = "TIME,…", value_delimiter = ',', value_parser = finite)]
    pictures_at: Vec<f64>,
    /// Write the frames in forms of other programs as well, into the folder `export` of the results
    #[arg(long, value_name = "FORM,…", value_delimiter = ',')]
    export: Vec<ExportFormat>,
    /// Write the metrics of all runs as one Parquet table as well, in folders `export/metrics/KEY=VALUE/` named by the
    /// sweep's coordinates (in a program built with `--features parquet`)
    #[arg(long)]
    table: bool,
    /// Read all recordings, also those that have not changed since they were analyzed last
    #[arg(long)]
    fresh: bool,
    /// Remember in the folder `.analyzed` what was found, and write nothing else: what a task of a cluster does, so that the
    /// analysis of the whole sweep reads no recording again
    #[arg(long, conflicts_with_all = ["checks", "export", "baseline", "junit", "github", "output"])]
    remember: bool,
    /// Compare with the metrics.json of an earlier analysis: exit code 3 if a metric has moved by more than 4 common
    /// standard errors
    #[arg(long, value_name = "FILE")]
    baseline: Vec<PathBuf>,
    /// Write the verdicts as JUnit XML
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Print what failed as annotations of a GitHub workflow
    #[arg(long)]
    github: bool,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print the reference of all metrics (Markdown) and stop
    #[arg(long, exclusive = true)]
    metrics: bool,
    /// Recordings, and folders of recordings; also on object storage as s3://BUCKET/PREFIX, in a program built with
    /// `--features object-storage`
    #[arg(required_unless_present = "metrics", value_name = "PATH")]
    paths: Vec<PathBuf>,
}

/// A picture of one recording, in the place of an analysis.
#[derive(Debug, clap::Args)]
struct PictureArguments {
    /// Draw the one recording that is named as a small picture, a .png or .svg, and stop
    #[arg(long, value_name = "FILE",
          conflicts_with_all = ["checks", "output", "pictures_at", "export", "fresh", "baseline", "junit", "github"])]
    thumbnail: Option<PathBuf>,
    /// Pictures of a thumbnail that moves (.png as APNG), evenly spread over the recording; 1 is its last frame
    #[arg(long, value_name = "N", default_value = "1", requires = "thumbnail")]
    thumbnail_frames: NonZeroU32,
    /// Width of a thumbnail in pixels, from 64 to 4096
    #[arg(long, value_name = "PIXELS", default_value = "480", requires = "thumbnail", value_parser = width)]
    thumbnail_width: NonZeroU32,
}

/// How the command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum AnalysisExit {
    /// Done; all checks hold.
    Done = 0,
    /// Bad arguments or checks file.
    Usage = 2,
    /// A check failed, or its metric is missing.
    CheckFailed = 3,
    /// Some input is unreadable; the rest was analyzed.
    UnreadableRecording = 5,
    /// The output can't be written; the same command may succeed later.
    Retry = 75,
}

/// Width of a table that goes to a file or a pipe.
const PLAIN_WIDTH: usize = 100;

/// Reads the command line, analyzes and reports.
#[must_use]
pub fn main() -> AnalysisExit {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Where even the message can't be printed, the exit code still says it.
            let _ = error.print();
            return if error.use_stderr() { AnalysisExit::Usage } else { AnalysisExit::Done };
        }
    };
    match run(&arguments) {
        Ok(exit) => exit,
        Err((exit, message)) => {
            eprintln!("error: {}", message.trim_end());
            exit
        }
    }
}

fn run(arguments: &Arguments) -> Result<AnalysisExit, (AnalysisExit, String)> {
    if arguments.metrics {
        print(&report::metrics_reference());
        return Ok(AnalysisExit::Done);
    }
    if let Some(file) = &arguments.picture.thumbnail {
        return draw(&arguments.picture, file, &arguments.paths);
    }
    let usage = |message| (AnalysisExit::Usage, message);
    let wants_parquet = arguments.table || arguments.export.contains(&ExportFormat::Parquet);
    if wants_parquet && cfg!(not(feature = "parquet")) {
        return Err(usage(export::NEEDS_PARQUET.to_owned()));
    }
    let checks = arguments.checks.as_deref().map_or_else(|| Ok(Vec::new()), read_checks);
    let checks = checks.map_err(usage)?;
    let baselines: Result<Vec<Baseline>, String> =
        arguments.baseline.iter().map(|path| read_baseline(path)).collect();
    let mut baselines = baselines.map_err(usage)?;
    let sources = sources(&arguments.paths)?;
    if arguments.output.is_none()
        && let Some(remote) = sources.iter().find(|source| source.is_remote())
    {
        let folder = remote.folder.display();
        return Err(usage(format!(
            "{folder} is not on this machine: name a folder for the results with --output DIR"
        )));
    }
    if arguments.remember {
        return Ok(fill_caches(sources, arguments));
    }
    let terminal = terminal();
    let several = sources.len() > 1;
    let mut reports: Vec<(PathBuf, AnalysisReport)> = Vec::new();
    for mut source in sources {
        let folder = match &arguments.output {
            Some(output) if several => output.join(&source.name),
            Some(output) => output.clone(),
            None => source.folder.clone(),
        };
        let options = AnalysisOptions {
            checks: checks.clone(),
            snapshots_at: arguments.pictures_at.clone(),
            cache: AnalysisCache::in_folder(&folder),
            fresh: arguments.fresh,
        };
        let mut report = analyze(&mut source, &options);
        if let Some(at) = baselines.iter().position(|old| old.experiment == report.name) {
            report.compare(&baselines.remove(at));
        }
        print(&report.text(terminal));
        export_all(&source, &arguments.export, &folder, terminal)?;
        #[cfg(feature = "parquet")]
        if arguments.table {
            let failed = |export::ExportError(why)| (AnalysisExit::Retry, why);
            write_table(&report, &folder, terminal).map_err(failed)?;
        }
        reports.push((folder, report));
    }
    if let Some(unused) = baselines.first() {
        let name = &unused.experiment;
        return Err(usage(format!("the baseline is of {name}, which is not among the recordings")));
    }
    write(arguments, &reports, terminal)
        .map_err(|error| (AnalysisExit::Retry, error.to_string()))?;
    Ok(conclude(&reports, terminal))
}

/// Finds the recordings behind the paths.
fn sources(paths: &[PathBuf]) -> Result<Vec<RecordingFolder>, (AnalysisExit, String)> {
    input::sources(paths).map_err(|InvalidPath { why, is_retryable }| {
        (if is_retryable { AnalysisExit::Retry } else { AnalysisExit::Usage }, why)
    })
}

/// Analyses and remembers; what could not be read is named.
fn fill_caches(sources: Vec<RecordingFolder>, arguments: &Arguments) -> AnalysisExit {
    let mut exit = AnalysisExit::Done;
    for mut source in sources {
        let options = AnalysisOptions {
            checks: Vec::new(),
            snapshots_at: arguments.pictures_at.clone(),
            cache: AnalysisCache::in_folder(&source.folder),
            fresh: arguments.fresh,
        };
        for why in report::fill_cache(&mut source, &options) {
            eprintln!("{why}");
            exit = AnalysisExit::UnreadableRecording;
        }
    }
    exit
}

/// Draws the one recording among the paths.
fn draw(
    picture: &PictureArguments,
    file: &Path,
    paths: &[PathBuf],
) -> Result<AnalysisExit, (AnalysisExit, String)> {
    let usage = |message: &str| (AnalysisExit::Usage, message.to_owned());
    let form = ThumbnailFormat::of(file, picture.thumbnail_frames).map_err(usage)?;
    let sources = sources(paths)?;
    let recordings: Vec<(&RecordingFolder, &PathBuf)> = sources
        .iter()
        .flat_map(|source| source.files.iter().map(move |path| (source, path)))
        .collect();
    let [(source, path)] = recordings.as_slice() else {
        return Err(usage("a thumbnail is of one recording: name its file"));
    };
    let unread = |error: ReadError| (AnalysisExit::UnreadableRecording, error.to_string());
    let recording = source.recording(path).map_err(unread)?;
    let wish = ThumbnailOptions { form, width: picture.thumbnail_width };
    let unreadable = |error: ThumbnailError| (AnalysisExit::UnreadableRecording, error.to_string());
    let drawn = thumbnail(&recording, wish).map_err(unreadable)?;
    let size = drawn.len().div_ceil(1000);
    write_file::replace(file, drawn).map_err(|error| (AnalysisExit::Retry, error.to_string()))?;
    print(&format!("written: {} ({size} kB)\n", file.display()));
    Ok(AnalysisExit::Done)
}

/// Exports the recordings in all forms that were asked for.
fn export_all(
    source: &RecordingFolder,
    forms: &[ExportFormat],
    folder: &Path,
    terminal: Terminal,
) -> Result<(), (AnalysisExit, String)> {
    let folder = folder.join("export");
    for form in forms {
        let failed = |export::ExportError(why)| (AnalysisExit::Retry, why);
        let count = export::export(source, *form, &folder).map_err(failed)?;
        let plural = if count == 1 { "recording" } else { "recordings" };
        let line = format!("exported: {count} {plural} to {}", folder.display());
        print(&format!("{}\n", terminal.wrapped(&line, 2)));
    }
    Ok(())
}

/// Writes all files, and says which.
fn write(
    arguments: &Arguments,
    reports: &[(PathBuf, AnalysisReport)],
    terminal: Terminal,
) -> Result<(), WriteError> {
    for (folder, report) in reports.iter().filter(|(_, report)| !report.runs.is_empty()) {
        let plots = files::write(report, folder)?;
        let line = format!(
            "written: report.html, metrics.json, metrics.csv and {plots} {} (*.svg) in {}",
            if plots == 1 { "plot" } else { "plots" },
            folder.display()
        );
        print(&format!("{}\n", terminal.wrapped(&line, 2)));
    }
    let all: Vec<_> = reports.iter().map(|(_, report)| report.checks()).collect();
    if let Some(path) = &arguments.junit {
        write_file::replace(path, ci_formats::junit(&all))?;
    }
    if arguments.github {
        print(&ci_formats::github(&all));
    }
    Ok(())
}

/// Writes the metrics of all runs as one table, and says where.
#[cfg(feature = "parquet")]
fn write_table(
    report: &AnalysisReport,
    folder: &Path,
    terminal: Terminal,
) -> Result<(), export::ExportError> {
    let folder = folder.join("export");
    let rows = export::sweep_table::write(&report.metrics, &folder)?;
    let line = format!("table: {rows} metrics of runs in {}", folder.join("metrics").display());
    print(&format!("{}\n", terminal.wrapped(&line, 2)));
    Ok(())
}

/// The gravest of what happened, and a last word on it.
fn conclude(reports: &[(PathBuf, AnalysisReport)], terminal: Terminal) -> AnalysisExit {
    let check_results = || reports.iter().flat_map(|(_, report)| &report.check_results);
    let failed = check_results().filter(|result| !result.passed).count();
    let unreadable: usize = reports.iter().map(|(_, report)| report.unreadable.len()).sum();
    if unreadable > 0 {
        let line = format!("{unreadable} unreadable: see above");
        eprintln!("{}", terminal.paint(Style::Bad, &line));
    }
    if failed > 0 {
        let line = format!("{failed} of {} checks failed", check_results().count());
        eprintln!("{}", terminal.paint(Style::Bad, &line));
        return AnalysisExit::CheckFailed;
    }
    if unreadable > 0 { AnalysisExit::UnreadableRecording } else { AnalysisExit::Done }
}

fn read_checks(path: &Path) -> Result<Vec<Check>, String> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| format!("the checks file {} can't be read: {error}", path.display()))?;
    parse_checks(&text, &path.display().to_string()).map_err(|diagnostics| diagnostics.to_string())
}

fn read_baseline(path: &Path) -> Result<Baseline, String> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| format!("the baseline {} can't be read: {error}", path.display()))?;
    Baseline::read(&text).map_err(|why| format!("{} {why}", path.display()))
}

/// A picture's width that programs can show.
fn width(text: &str) -> Result<NonZeroU32, String> {
    let width = text.parse().ok().filter(|width: &NonZeroU32| (64..=4096).contains(&width.get()));
    width.ok_or_else(|| "must be a number from 64 to 4096".to_owned())
}

/// A finite number.
fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "must be a number".to_owned())
}

fn terminal() -> Terminal {
    let interactive = std::io::stdout().is_terminal();
    let size = terminal_size::terminal_size().filter(|_| interactive);
    let columns = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let width = size.map(|(width, _)| usize::from(width.0)).or(columns).unwrap_or(PLAIN_WIDTH);
    let colors = interactive && std::env::var_os("NO_COLOR").is_none();
    Terminal { width: width.max(40), colors }
}

/// Prints; a reader that went away (`| head`) is no error.
fn print(text: &str) {
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}
