//! The command line of `analyze-recordings` and `kinetoscope analyze`, and its exit codes.

use crate::baseline::Baseline;
use crate::export::{self, Form};
use crate::files::{self, WriteError};
use crate::input::{BadPath, Source};
use crate::memory::Memory;
use crate::report::{self, Report, Wishes, analyze};
use crate::table::{Terminal, Tone};
use crate::{catalog, ci, input, metrics};
use clap::Parser;
use kinetoscope_manifest::{Check, parse_checks};
use kinetoscope_usage::Ended;
use serde_json::json;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

/// The exit codes as the help shows them.
pub const EXIT_CODES: &str = "Exit codes:
  0    done, and all checks pass
  2    bad arguments or checks file
  3    a check failed or its metric is missing, or a metric
       has changed from the baseline
  5    some input is unreadable; the rest was analyzed
  75   the results cannot be written: the same command may
       succeed later";

/// Compute metrics with standard errors, plots and checks from recordings
///
/// Writes report.html, metrics.json, metrics.csv and one file per plot next to the recordings.
#[derive(Debug, Parser)]
#[command(name = "analyze-recordings", version, after_help = EXIT_CODES)]
struct AnalyzeRecordings {
    #[command(flatten)]
    analyze: AnalyzeArguments,
}

/// Compute metrics with standard errors, plots and checks from recordings.
#[derive(Debug, clap::Args)]
pub struct AnalyzeArguments {
    /// Recordings, and folders of recordings; also on object storage as s3://BUCKET/PREFIX, in a program built with
    /// `--features object-storage`
    #[arg(required_unless_present = "list_metrics", value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Print the reference of all metrics (Markdown) and stop
    #[arg(long, exclusive = true)]
    list_metrics: bool,
    /// Read all recordings, including those that have not changed since their last analysis
    #[arg(long)]
    no_cache: bool,
    /// Write the cache `.analysis-cache` only, as a task of a cluster does, so that a later analysis reads no recording again
    #[arg(long, conflicts_with_all = ["checks", "export", "baseline", "junit", "github_annotations", "output", "json"])]
    cache_only: bool,
    /// TOML file with [[checks]] in addition to those of the experiment
    #[arg(long, value_name = "FILE", help_heading = "Checks")]
    checks: Option<PathBuf>,
    /// Compare with the metrics.json of an earlier analysis: exit code 3 if a metric has changed by more than 4 combined
    /// standard errors
    #[arg(long, value_name = "FILE", help_heading = "Checks")]
    baseline: Vec<PathBuf>,
    /// Write the results of the checks as JUnit XML
    #[arg(long, value_name = "FILE", help_heading = "Checks")]
    junit: Option<PathBuf>,
    /// Print failed checks as annotations of a GitHub workflow
    #[arg(long, help_heading = "Checks")]
    github_annotations: bool,
    /// Folder for the results [default: that of the recordings]
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    output: Option<PathBuf>,
    /// Draw the state at these times as well, in the model's unit, in addition to start and end
    #[arg(long, value_name = "TIME,…", value_delimiter = ',', value_parser = finite, help_heading = "Output")]
    snapshots_at: Vec<f64>,
    /// Write the frames in the formats of other programs as well, to the folder `export` of the results
    #[arg(long, value_name = "FORMAT,…", value_delimiter = ',', help_heading = "Output")]
    export: Vec<Form>,
    /// Write the metrics of all runs as one Parquet table as well, in folders `export/metrics/KEY=VALUE/` named by the
    /// coordinates of the sweep (in a program built with `--features parquet`)
    #[arg(long, help_heading = "Output")]
    metrics_table: bool,
    /// Print errors only
    #[arg(long, short, help_heading = "Messages")]
    quiet: bool,
    /// Print metrics and checks as JSON
    #[arg(long, conflicts_with = "github_annotations", help_heading = "Messages")]
    json: bool,
}

/// How the command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Done; all checks hold.
    Done = 0,
    /// Bad arguments or checks file.
    Usage = 2,
    /// A check failed, or its metric is missing.
    CheckFailed = 3,
    /// Some input is unreadable; the rest was analyzed.
    Unreadable = 5,
    /// The output can't be written; the same command may succeed later.
    Retry = 75,
}

/// Width of a table that goes to a file or a pipe.
const PLAIN_WIDTH: usize = 100;

/// The program `analyze-recordings`.
#[must_use]
pub fn main() -> Exit {
    match AnalyzeRecordings::try_parse() {
        Ok(arguments) => arguments.analyze.execute(),
        Err(error) => match kinetoscope_usage::report(&error, "analyze-recordings") {
            Ended::Answered => Exit::Done,
            Ended::Rejected => Exit::Usage,
        },
    }
}

impl AnalyzeArguments {
    /// Analyzes the recordings and prints the results.
    #[must_use]
    pub fn execute(&self) -> Exit {
        concluded(run(self))
    }

    /// Prints a text, unless errors only or JSON are requested.
    fn say(&self, text: &str) {
        if !self.quiet && !self.json {
            print(text);
        }
    }
}

/// Prints the error of a command, and returns its exit code.
pub(crate) fn concluded(result: Result<Exit, (Exit, String)>) -> Exit {
    result.unwrap_or_else(|(exit, message)| {
        complain(&format!("error: {}", message.trim_end()));
        exit
    })
}

/// Analyzes recordings and caches the results next to them.
///
/// # Errors
/// Why not all recordings were analyzed.
pub fn cache(recordings: &[PathBuf]) -> Result<(), String> {
    let sources = input::sources(recordings).map_err(|BadPath { why, .. }| why)?;
    let errors = cache_sources(sources, &[], false);
    if errors.is_empty() { Ok(()) } else { Err(errors.join("; ")) }
}

fn run(arguments: &AnalyzeArguments) -> Result<Exit, (Exit, String)> {
    if arguments.list_metrics {
        print(&catalog::reference());
        return Ok(Exit::Done);
    }
    let usage = |message| (Exit::Usage, message);
    let wants_parquet = arguments.metrics_table || arguments.export.contains(&Form::Parquet);
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
    if arguments.cache_only {
        let errors = cache_sources(sources, &arguments.snapshots_at, arguments.no_cache);
        errors.iter().for_each(|error| complain(&format!("error: {error}")));
        return Ok(if errors.is_empty() { Exit::Done } else { Exit::Unreadable });
    }
    let terminal = terminal();
    let several = sources.len() > 1;
    let mut reports: Vec<(PathBuf, Report)> = Vec::new();
    for mut source in sources {
        let folder = match &arguments.output {
            Some(output) if several => output.join(&source.name),
            Some(output) => output.clone(),
            None => source.folder.clone(),
        };
        let wishes = Wishes {
            checks: checks.clone(),
            pictures_at: arguments.snapshots_at.clone(),
            memory: Memory::beside(&folder),
            fresh: arguments.no_cache,
        };
        let mut report = analyze(&mut source, &wishes);
        if let Some(at) = baselines.iter().position(|old| old.experiment == report.name) {
            report.compare(&baselines.remove(at));
        }
        arguments.say(&report.text(terminal));
        for line in export_all(&source, &arguments.export, &folder.join("export"), terminal)? {
            arguments.say(&line);
        }
        #[cfg(feature = "parquet")]
        if arguments.metrics_table {
            let failed = |export::ExportError(why)| (Exit::Retry, why);
            arguments.say(&write_table(&report, &folder, terminal).map_err(failed)?);
        }
        reports.push((folder, report));
    }
    if let Some(unused) = baselines.first() {
        let name = &unused.experiment;
        return Err(usage(format!("the baseline is of {name}, which is not among the recordings")));
    }
    write(arguments, &reports, terminal).map_err(|error| (Exit::Retry, error.to_string()))?;
    let exit = conclude(&reports, terminal);
    if arguments.json {
        print(&json(&reports, exit));
    }
    Ok(exit)
}

/// Metrics and checks of all experiments, as one JSON document.
fn json(reports: &[(PathBuf, Report)], exit: Exit) -> String {
    let experiments = reports.iter().map(|(folder, report)| {
        let metrics = metrics::to_json(&report.name, report.model(), &report.metrics)
            .ok()
            .and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok());
        let checks = report.verdicts.iter().map(|verdict| {
            json!({ "subject": verdict.subject, "passed": verdict.holds, "finding": verdict.finding })
        });
        json!({
            "folder": folder,
            "analysis": metrics,
            "checks": checks.collect::<Vec<_>>(),
            "unreadable": report.unreadable,
        })
    });
    let experiments: Vec<_> = experiments.collect();
    format!("{:#}\n", json!({ "exit_code": exit as u8, "experiments": experiments }))
}

/// Finds the recordings behind the paths.
pub(crate) fn sources(paths: &[PathBuf]) -> Result<Vec<Source>, (Exit, String)> {
    input::sources(paths).map_err(|BadPath { why, is_retryable }| {
        (if is_retryable { Exit::Retry } else { Exit::Usage }, why)
    })
}

/// Analyzes the recordings and writes the cache only; returns why recordings could not be read.
fn cache_sources(sources: Vec<Source>, snapshots_at: &[f64], no_cache: bool) -> Vec<String> {
    let mut errors = Vec::new();
    for mut source in sources {
        let wishes = Wishes {
            checks: Vec::new(),
            pictures_at: snapshots_at.to_vec(),
            memory: Memory::beside(&source.folder),
            fresh: no_cache,
        };
        errors.append(&mut report::remember(&mut source, &wishes));
    }
    errors
}

/// Exports the recordings in all requested formats to a folder; returns one line per format for the user.
pub(crate) fn export_all(
    source: &Source,
    formats: &[Form],
    folder: &Path,
    terminal: Terminal,
) -> Result<Vec<String>, (Exit, String)> {
    let mut lines = Vec::new();
    for format in formats {
        let failed = |export::ExportError(why)| (Exit::Retry, why);
        let count = export::export(source, *format, folder).map_err(failed)?;
        let plural = if count == 1 { "recording" } else { "recordings" };
        let line = format!("exported: {count} {plural} to {}", folder.display());
        lines.push(format!("{}\n", terminal.wrapped(&line, 2)));
    }
    Ok(lines)
}

/// Writes all files, and says which.
fn write(
    arguments: &AnalyzeArguments,
    reports: &[(PathBuf, Report)],
    terminal: Terminal,
) -> Result<(), WriteError> {
    for (folder, report) in reports.iter().filter(|(_, report)| !report.runs.is_empty()) {
        let plots = files::write(report, folder)?;
        let line = format!(
            "written: report.html, metrics.json, metrics.csv and {plots} {} (*.svg) in {}",
            if plots == 1 { "plot" } else { "plots" },
            folder.display()
        );
        arguments.say(&format!("{}\n", terminal.wrapped(&line, 2)));
    }
    let all: Vec<&Report> = reports.iter().map(|(_, report)| report).collect();
    if let Some(path) = &arguments.junit {
        files::replace(path, ci::junit(&all))?;
    }
    if arguments.github_annotations {
        print(&ci::github(&all));
    }
    Ok(())
}

/// Writes the metrics of all runs as one table, and says where.
#[cfg(feature = "parquet")]
fn write_table(
    report: &Report,
    folder: &Path,
    terminal: Terminal,
) -> Result<String, export::ExportError> {
    let folder = folder.join("export");
    let rows = export::sweep_table::write(&report.metrics, &folder)?;
    let line = format!("table: {rows} metrics of runs in {}", folder.join("metrics").display());
    Ok(format!("{}\n", terminal.wrapped(&line, 2)))
}

/// The gravest of what happened, and a last word on it.
fn conclude(reports: &[(PathBuf, Report)], terminal: Terminal) -> Exit {
    let verdicts = || reports.iter().flat_map(|(_, report)| &report.verdicts);
    let failed = verdicts().filter(|verdict| !verdict.holds).count();
    let unreadable: usize = reports.iter().map(|(_, report)| report.unreadable.len()).sum();
    if unreadable > 0 {
        let line = format!("{unreadable} unreadable: see above");
        complain(&terminal.paint(Tone::Bad, &line));
    }
    if failed > 0 {
        let line = format!("{failed} of {} checks failed", verdicts().count());
        complain(&terminal.paint(Tone::Bad, &line));
        return Exit::CheckFailed;
    }
    if unreadable > 0 { Exit::Unreadable } else { Exit::Done }
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

/// A finite number.
fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "must be a number".to_owned())
}

/// The terminal that standard output goes to, or a plain page.
pub(crate) fn terminal() -> Terminal {
    let interactive = std::io::stdout().is_terminal();
    let size = terminal_size::terminal_size().filter(|_| interactive);
    let columns = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let width = size.map(|(width, _)| usize::from(width.0)).or(columns).unwrap_or(PLAIN_WIDTH);
    let colors = interactive && std::env::var_os("NO_COLOR").is_none();
    Terminal { width: width.max(40), colors }
}

/// Prints a line to standard error. If it is closed, the exit code still reports the error.
fn complain(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Prints a text to standard output. A closed pipe (`| head`) is not an error.
pub(crate) fn print(text: &str) {
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}
