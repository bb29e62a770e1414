//! The program `analyze-recordings`: from the command line to files, text and an exit code.

mod arguments;
mod exit;

use crate::checks::baseline::Baseline;
use crate::checks::ci_formats;
use crate::export::{self, ExportFormat};
use crate::input::{self, RecordingFolder};
use crate::report::files;
use crate::report::table::{Style, Terminal};
use crate::report::{self, AnalysisOptions, AnalysisReport, analyze};
use crate::run::cache::AnalysisCache;
use crate::thumbnail::{ThumbnailFormat, ThumbnailOptions, thumbnail};
use crate::write_file::{self, WriteError};
use arguments::{Arguments, PictureArguments};
use clap::Parser;
pub use exit::AnalysisExit;
use exit::CommandError;
use kinetoscope_manifest::{Check, parse_checks};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Width of a table that is written to a file or a pipe.
const PLAIN_WIDTH: usize = 100;

/// Parses the command line, analyzes the recordings and reports.
#[must_use]
pub fn main() -> AnalysisExit {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // If even the message cannot be printed, the exit code still reports the error.
            let _ = error.print();
            return if error.use_stderr() { AnalysisExit::Usage } else { AnalysisExit::Done };
        }
    };
    match run(&arguments) {
        Ok(exit) => exit,
        Err(CommandError { exit, message }) => {
            eprintln!("error: {}", message.trim_end());
            exit
        }
    }
}

fn run(arguments: &Arguments) -> Result<AnalysisExit, CommandError> {
    if arguments.metrics {
        print(&report::metrics_reference());
        return Ok(AnalysisExit::Done);
    }
    if let Some(file) = &arguments.picture.thumbnail {
        return draw(&arguments.picture, file, &arguments.paths);
    }
    let wants_parquet = arguments.table || arguments.export.contains(&ExportFormat::Parquet);
    if wants_parquet && cfg!(not(feature = "parquet")) {
        return Err(CommandError::usage(export::NEEDS_PARQUET));
    }
    let checks = arguments.checks.as_deref().map_or_else(|| Ok(Vec::new()), read_checks);
    let checks = checks.map_err(CommandError::usage)?;
    let baselines: Result<Vec<Baseline>, String> =
        arguments.baseline.iter().map(|path| read_baseline(path)).collect();
    let mut baselines = baselines.map_err(CommandError::usage)?;
    let sources = input::sources(&arguments.paths)?;
    if arguments.output.is_none()
        && let Some(remote) = sources.iter().find(|source| source.is_remote())
    {
        let folder = remote.folder.display();
        return Err(CommandError::usage(format!(
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
            write_table(&report, &folder, terminal)?;
        }
        reports.push((folder, report));
    }
    if let Some(unused) = baselines.first() {
        let name = &unused.experiment;
        return Err(CommandError::usage(format!(
            "the baseline is of {name}, which is not among the recordings"
        )));
    }
    write(arguments, &reports, terminal)?;
    Ok(conclude(&reports, terminal))
}

/// Fills the caches of the folders and prints what could not be read.
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
            exit = AnalysisExit::Unreadable;
        }
    }
    exit
}

/// Draws the thumbnail of the one recording among the paths.
fn draw(
    picture: &PictureArguments,
    file: &Path,
    paths: &[PathBuf],
) -> Result<AnalysisExit, CommandError> {
    let format =
        ThumbnailFormat::of(file, picture.thumbnail_frames).map_err(CommandError::usage)?;
    let sources = input::sources(paths)?;
    let recordings: Vec<(&RecordingFolder, &PathBuf)> = sources
        .iter()
        .flat_map(|source| source.files.iter().map(move |path| (source, path)))
        .collect();
    let [(source, path)] = recordings.as_slice() else {
        return Err(CommandError::usage("a thumbnail is of one recording: name its file"));
    };
    let recording = source.recording(path).map_err(CommandError::unreadable)?;
    let options = ThumbnailOptions { format, width: picture.thumbnail_width };
    let drawn = thumbnail(&recording, options).map_err(CommandError::unreadable)?;
    let size = drawn.len().div_ceil(1000);
    write_file::replace(file, drawn)?;
    print(&format!("written: {} ({size} kB)\n", file.display()));
    Ok(AnalysisExit::Done)
}

/// Exports the recordings in all requested formats.
fn export_all(
    source: &RecordingFolder,
    formats: &[ExportFormat],
    folder: &Path,
    terminal: Terminal,
) -> Result<(), CommandError> {
    let folder = folder.join("export");
    for format in formats {
        let count = export::export(source, *format, &folder)?;
        let plural = if count == 1 { "recording" } else { "recordings" };
        let line = format!("exported: {count} {plural} to {}", folder.display());
        print(&format!("{}\n", terminal.wrapped(&line, 2)));
    }
    Ok(())
}

/// Writes all files and prints which.
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

/// Writes the metrics of all runs as one table and prints where.
#[cfg(feature = "parquet")]
fn write_table(
    report: &AnalysisReport,
    folder: &Path,
    terminal: Terminal,
) -> Result<(), WriteError> {
    let folder = folder.join("export");
    let rows = export::sweep_table::write(&report.metrics, &folder)?;
    let line = format!("table: {rows} metrics of runs in {}", folder.join("metrics").display());
    print(&format!("{}\n", terminal.wrapped(&line, 2)));
    Ok(())
}

/// Prints a summary of failures and returns the worst exit code.
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
    if unreadable > 0 { AnalysisExit::Unreadable } else { AnalysisExit::Done }
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

fn terminal() -> Terminal {
    let interactive = std::io::stdout().is_terminal();
    let size = terminal_size::terminal_size().filter(|_| interactive);
    let columns = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let width = size.map(|(width, _)| usize::from(width.0)).or(columns).unwrap_or(PLAIN_WIDTH);
    let colors = interactive && std::env::var_os("NO_COLOR").is_none();
    Terminal { width: width.max(40), colors }
}

/// Prints; a reader that closed the pipe (`| head`) is not an error.
fn print(text: &str) {
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}
