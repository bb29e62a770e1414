//! The programs `analyze-recordings`, `kinetoscope analyze`, `kinetoscope export`, `kinetoscope plot` and `kinetoscope table`: from arguments to files, text and an exit code.

mod arguments;
mod exit;
mod export_arguments;
mod meant_paths;
mod messages;
mod pages;
mod plot_arguments;
mod plotted_names;
#[cfg(feature = "parquet")]
mod table_arguments;

pub use arguments::{AnalyzeArguments, EXIT_CODES};
pub use export_arguments::ExportArguments;
pub use plot_arguments::PlotArguments;
#[cfg(feature = "parquet")]
pub use table_arguments::TableArguments;

use crate::checks::baseline::{Baseline, BaselineComparison};
use crate::checks::ci_formats::{self, ExperimentChecks};
use crate::checks::outcome::number_of_runs;
use crate::checks::{CheckKind, CheckResult};
use crate::export::{self, ExportFormat};
use crate::input::{self, ON_FAILED_DISK, RecordingFolder, UnreadableRecording};
use crate::models::metric_names;
use crate::report::engine_place::EnginePlace;
use crate::report::files;
use crate::report::table::{Style, Terminal};
use crate::report::{self, AnalysisOptions, AnalysisReport, analyze, snapshots_outside};
use crate::run::cache::AnalysisCache;
use crate::write_file::{self, WriteError};
use exit::CommandError;
use export_arguments::export_all;
use kinetoscope_console::text::{one_line, plural, shown_path};
use kinetoscope_console::{Exit, Message, complain};
use kinetoscope_files::regular_file::is_of_file;
use kinetoscope_files::regular_file::{MAX_SIDE_FILE_BYTES, read_text};
use kinetoscope_manifest::{Check, parse_checks};
use meant_paths::meant_paths;
use messages::{complain_unreadable, concluded, terminal};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// An experiment with its analysis.
struct Analyzed {
    /// The folder of the results.
    results: PathBuf,
    report: AnalysisReport,
}

impl Analyzed {
    /// Whether no run could be read, so that there are no results.
    fn is_empty(&self) -> bool {
        self.report.runs.is_empty()
    }
}

impl AnalyzeArguments {
    /// Analyzes the recordings and prints the results. `engine` is that of report pages as gzip; empty if the program does not carry it.
    #[must_use]
    pub fn execute(&self, engine: &'static [u8]) -> Exit {
        concluded(run(self, engine), &self.standard_output, self.json)
    }

    /// Prints a text, unless only errors or JSON are requested.
    fn say(&self, text: &str) {
        if !self.quiet && !self.json {
            self.standard_output.print_styled(text);
        }
    }
}

/// Analyzes recordings and caches the results next to them.
///
/// # Errors
/// The reasons why not all recordings were analyzed.
pub fn cache(recordings: &[PathBuf]) -> Result<(), String> {
    let sources = input::sources(recordings).map_err(|error| error.message.clause())?;
    let errors = fill_caches(sources, |folder| AnalysisOptions {
        cache: AnalysisCache::in_folder(folder),
        replay_bytes: Some(arguments::REPLAY_BYTES),
        ..AnalysisOptions::default()
    });
    let errors: Vec<String> = errors.iter().map(|error| error.message.clause()).collect();
    if errors.is_empty() { Ok(()) } else { Err(errors.join("; ")) }
}

fn run(arguments: &AnalyzeArguments, engine: &'static [u8]) -> Result<Exit, CommandError> {
    if let Some(words) = &arguments.list_metrics {
        return list_metrics(arguments, words);
    }
    let wants_parquet =
        arguments.metrics_table || arguments.export.contains(&ExportFormat::Parquet);
    if wants_parquet && cfg!(not(feature = "parquet")) {
        return Err(CommandError::usage(export::needs_parquet()));
    }
    let checks = arguments.checks.as_deref().map_or_else(|| Ok(Vec::new()), read_checks)?;
    let mut baselines = read_baselines(&arguments.baseline)?;
    arguments.junit.as_deref().map_or(Ok(()), write_file::check)?;
    let paths = meant_paths(&arguments.paths)?;
    let sources = sources(arguments, &paths)?;
    reject_other_baselines(&baselines, &sources)?;
    if arguments.cache_only {
        let errors = fill_caches(sources, |folder| analysis_options(arguments, folder, engine));
        errors.iter().for_each(complain_unreadable);
        return Ok(UnreadableRecording::exit(&errors).unwrap_or(Exit::Done));
    }
    if arguments.single_file && engine.is_empty() && !arguments.quiet {
        let note = "note: this program was built without the engine for browsers: the page cannot verify its runs";
        complain(note, false);
    }
    let terminal = terminal();
    let several = input::are_several(&sources);
    if several && arguments.output.is_some() {
        reject_equal_names(&sources)?;
    }
    let check =
        |source| write_file::check_results_folder(&results_folder(arguments, source, several));
    arguments.output.as_ref().map_or(Ok(()), |_| sources.iter().try_for_each(check))?;
    let mut analyzed: Vec<Analyzed> = Vec::new();
    for mut source in sources {
        let folder = results_folder(arguments, &source, several);
        let options = AnalysisOptions {
            checks: checks.clone(),
            checks_file: arguments.checks.as_ref().map(|path| path.to_string_lossy().into_owned()),
            ..analysis_options(arguments, &folder, engine)
        };
        let mut report = analyze(&mut source, &options);
        if let Some(at) = baselines.iter().position(|old| old.experiment() == report.name) {
            let compared = report.compare(&baselines.remove(at), &arguments.allow_changed);
            compared.map_err(CommandError::usage)?;
        }
        arguments.say(&report.text(terminal, arguments.extent()));
        let say = |line: &str| arguments.say(line);
        // The report names them already.
        export_all(&source, &arguments.export, &folder.join("export"), say, &mut BTreeSet::new())?;
        #[cfg(feature = "parquet")]
        if arguments.metrics_table {
            arguments.say(&write_table(&report, &folder, terminal)?);
        }
        analyzed.push(Analyzed { results: folder, report });
    }
    if let Some(unused) = baselines.first() {
        return Err(CommandError::usage(Message::new(
            format!("there are two baselines of the experiment {}", unused.experiment()),
            "name one of them",
        )));
    }
    reject_snapshots_outside(&arguments.snapshots_at, &analyzed)?;
    write(arguments, &analyzed, terminal)?;
    if arguments.open {
        pages::open(&analyzed, arguments);
    }
    let exit = conclude(&analyzed, terminal, arguments.quiet);
    pages::name_earlier_reports(&analyzed);
    if arguments.json {
        arguments.standard_output.print_json(&json(&analyzed, exit));
    }
    Ok(exit)
}

/// Rejects a time of `--snapshots-at` that no run of any experiment reaches.
fn reject_snapshots_outside(times: &[f64], analyzed: &[Analyzed]) -> Result<(), CommandError> {
    let read = analyzed.iter().filter(|one| !one.is_empty());
    let mut outside = read.map(|one| snapshots_outside(&one.report.runs, times));
    let first = outside.next().unwrap_or_default();
    match first.first() {
        Some(what) if outside.all(|others| !others.is_empty()) => Err(CommandError::usage(
            Message::new(what.as_str(), "name times that the recordings have"),
        )),
        _ => Ok(()),
    }
}

/// Prints the reference of all metrics, or those with the words.
fn list_metrics(arguments: &AnalyzeArguments, words: &[String]) -> Result<Exit, CommandError> {
    if words.is_empty() {
        arguments.standard_output.print(&report::metrics_reference());
        return Ok(Exit::Done);
    }
    let text = report::metrics_with(words, terminal()).ok_or_else(|| {
        CommandError::usage(Message::new(
            format!("no metric has the words {:?}", words.join(" ")),
            "name a model (dem, gas, packing, orbit), a part of a metric's name, or fewer words",
        ))
    })?;
    arguments.standard_output.print_styled(&text);
    Ok(Exit::Done)
}

fn read_baselines(paths: &[PathBuf]) -> Result<Vec<Baseline>, CommandError> {
    paths.iter().map(|path| read_baseline(path)).collect()
}

/// Rejects a baseline of an experiment that is not among the recordings.
fn reject_other_baselines(
    baselines: &[Baseline],
    sources: &[RecordingFolder],
) -> Result<(), CommandError> {
    let is_among = |old: &&Baseline| sources.iter().any(|source| source.name == old.experiment());
    match baselines.iter().find(|old| !is_among(old)) {
        Some(old) => Err(CommandError::usage(Message::new(
            format!(
                "the baseline is of the experiment {}, which is not among the recordings",
                old.experiment()
            ),
            "name its recordings as well, or omit --baseline",
        ))),
        None => Ok(()),
    }
}

/// Rejects experiments whose results would replace each other in the folder of `--output`.
fn reject_equal_names(sources: &[RecordingFolder]) -> Result<(), CommandError> {
    let mut folders = BTreeMap::new();
    for source in sources.iter().filter(|source| !source.is_empty()) {
        if let Some(other) = folders.insert(&source.name, &source.folder) {
            let (one, other) = (shown_path(&source.folder), shown_path(other));
            return Err(CommandError::usage(Message::new(
                format!(
                    "{other} and {one} have the same name, so their results would be in one folder"
                ),
                "analyze each with its own --output, or omit --output",
            )));
        }
    }
    Ok(())
}

/// The folder of the results of one experiment among one or several.
fn results_folder(
    arguments: &AnalyzeArguments,
    source: &RecordingFolder,
    several: bool,
) -> PathBuf {
    match &arguments.output {
        Some(output) if several => output.join(&source.name),
        Some(output) => output.clone(),
        None => source.folder.clone(),
    }
}

/// The options of an analysis with results in a folder, without further checks.
fn analysis_options(
    arguments: &AnalyzeArguments,
    folder: &Path,
    engine: &'static [u8],
) -> AnalysisOptions {
    AnalysisOptions {
        checks: Vec::new(),
        checks_file: None,
        snapshots_at: arguments.snapshots_at.clone(),
        cache: AnalysisCache::in_folder(folder),
        fresh: arguments.no_cache,
        replay_bytes: arguments.replay_bytes(),
        engine: EnginePlace::chosen(engine, arguments.no_engine, arguments.single_file),
    }
}

/// Metrics and checks of all experiments, as one JSON document.
fn json(analyzed: &[Analyzed], exit: Exit) -> String {
    let experiments = analyzed.iter().map(|Analyzed { results: folder, report, .. }| {
        let metrics = serde_json::to_value(report.document()).ok();
        let checks = report.check_results.iter().map(|result| {
            json!({ "subject": result.subject, "passed": result.passed, "finding": result.finding })
        });
        json!({
            "folder": folder,
            "analysis": metrics,
            "checks": checks.collect::<Vec<_>>(),
            "baseline": report.baseline.as_ref().map(BaselineComparison::json),
            "unreadable": report.unreadable.iter().map(|why| why.message.clause()).collect::<Vec<_>>(),
        })
    });
    let experiments: Vec<_> = experiments.collect();
    format!("{:#}\n", json!({ "exit_code": exit.code(), "experiments": experiments }))
}

/// Fills the caches of the folders; returns the reasons why recordings could not be read.
fn fill_caches(
    sources: Vec<RecordingFolder>,
    options: impl Fn(&Path) -> AnalysisOptions,
) -> Vec<UnreadableRecording> {
    let mut errors = Vec::new();
    for mut source in sources {
        let options = options(&source.folder);
        errors.append(&mut report::fill_cache(&mut source, &options));
    }
    errors
}

/// Writes all files and prints which.
fn write(
    arguments: &AnalyzeArguments,
    analyzed: &[Analyzed],
    terminal: Terminal,
) -> Result<(), WriteError> {
    for Analyzed { results: folder, report, .. } in analyzed.iter().filter(|one| !one.is_empty()) {
        let plots = files::write(report, folder)?;
        let line = format!(
            "written: {}, with metrics.json, metrics.csv and {} (*.svg)",
            shown_path(&folder.join(files::REPORT)),
            plural(plots as u64, "plot"),
        );
        arguments.say(&format!("{}\n", terminal.wrapped(&line, 2)));
    }
    for folder in pages::write_indexes(analyzed, arguments)? {
        let line = format!("written: {}", shown_path(&folder.join(files::INDEX)));
        arguments.say(&format!("{}\n", terminal.wrapped(&line, 2)));
    }
    let all: Vec<_> = analyzed.iter().map(|one| one.report.checks()).collect();
    write_for_ci(arguments, &all)
}

/// The folders of the recordings. If there are none, the JUnit file states that.
fn sources(
    arguments: &AnalyzeArguments,
    paths: &[PathBuf],
) -> Result<Vec<RecordingFolder>, CommandError> {
    let sources = match input::sources_and_tables(paths) {
        Ok(sources) => sources,
        Err(error) => {
            write_unread(arguments, &error.message)?;
            return Err(error.into());
        }
    };
    if arguments.output.is_none()
        && let Some(remote) = sources.iter().find(|source| source.is_remote())
    {
        let folder = shown_path(&remote.folder);
        return Err(CommandError::usage(Message::new(
            format!("{folder} is not on this machine"),
            "name a folder for the results with --output DIR",
        )));
    }
    Ok(sources)
}

/// Writes that nothing could be analyzed, where a CI system expects the results.
fn write_unread(arguments: &AnalyzeArguments, reason: &Message) -> Result<(), WriteError> {
    let unreadable = [reason.clone().into()];
    let nothing = ExperimentChecks {
        name: "recordings",
        manifest: None,
        answer: String::new(),
        check_results: &[],
        unreadable: &unreadable,
    };
    write_for_ci(arguments, &[nothing])
}

/// Writes the results in the formats of CI systems: a JUnit file, annotations, and the summary of a workflow's step.
fn write_for_ci(
    arguments: &AnalyzeArguments,
    all: &[ExperimentChecks<'_>],
) -> Result<(), WriteError> {
    if let Some(path) = &arguments.junit {
        write_file::write(path, ci_formats::junit(all))?;
    }
    if arguments.github_annotations {
        arguments.standard_output.print_exactly(&ci_formats::github(all));
        if let Some(path) = std::env::var_os("GITHUB_STEP_SUMMARY") {
            write_file::append(Path::new(&path), &ci_formats::markdown(all))?;
        }
    }
    Ok(())
}

/// Writes the metrics of all runs as one table; returns a line for the user.
#[cfg(feature = "parquet")]
fn write_table(
    report: &AnalysisReport,
    folder: &Path,
    terminal: Terminal,
) -> Result<String, WriteError> {
    let folder = folder.join("export");
    let rows = export::sweep_table::write(&report.metrics, &folder)?;
    let line = format!("table: {rows} metrics of runs in {}", shown_path(&folder.join("metrics")));
    Ok(format!("{}\n", terminal.wrapped(&line, 2)))
}

/// Prints each failed check with its experiment, which a quiet analysis has not printed.
fn name_failures(analyzed: &[Analyzed]) {
    for Analyzed { report, .. } in analyzed {
        for failed in report.check_results.iter().filter(|result| !result.passed) {
            complain(
                &format!("FAILED {}: {}", one_line(&report.name), one_line(&failed.text())),
                false,
            );
        }
    }
}

/// Prints what is unreadable and a summary of failures, and returns the worst exit code.
fn conclude(analyzed: &[Analyzed], terminal: Terminal, is_quiet: bool) -> Exit {
    if is_quiet {
        name_failures(analyzed);
    }
    let unreadable: Vec<&UnreadableRecording> =
        analyzed.iter().flat_map(|one| &one.report.unreadable).collect();
    unreadable.iter().for_each(|why| complain_unreadable(why));
    let runs = |is_counted: fn(&&CheckResult) -> bool| {
        let of_one =
            |one: &Analyzed| number_of_runs(one.report.check_results.iter().filter(is_counted));
        analyzed.iter().map(of_one).sum::<usize>()
    };
    let checks = |is_counted: fn(&&CheckResult) -> bool| {
        let all = analyzed.iter().flat_map(|one| &one.report.check_results);
        all.filter(is_counted).filter(|result| result.kind != CheckKind::Outcome).count()
    };
    let (all, failed) = (|_: &&CheckResult| true, |result: &&CheckResult| !result.passed);
    let mut has_failed = false;
    for (failed, all, what, ending) in [
        (runs(failed), runs(all), "run", "ended otherwise than expected"),
        (checks(failed), checks(all), "check", "failed"),
    ] {
        if failed > 0 {
            let line = format!("{failed} of {} {ending}", plural(all as u64, what));
            complain(&terminal.paint(Style::Bad, &line), terminal.colors);
            has_failed = true;
        }
    }
    if has_failed {
        return Exit::CheckFailed;
    }
    UnreadableRecording::exit(unreadable).unwrap_or(Exit::Done)
}

fn read_checks(path: &Path) -> Result<Vec<Check>, CommandError> {
    let text = read_argument(path, "checks file", "a TOML file of [[checks]]")?;
    parse_checks(&text, &path.to_string_lossy(), Some(metric_names))
        .map_err(|diagnostics| CommandError::usage(diagnostics.to_string().trim_end()))
}

fn read_baseline(path: &Path) -> Result<Baseline, CommandError> {
    let text = read_argument(path, "baseline", "the metrics.json of an earlier analysis")?;
    Baseline::read(&text).map_err(|why| {
        let help = "write it again with this version of analyze-recordings";
        CommandError::usage(Message::new(format!("{} {why}", shown_path(path)), help))
    })
}

/// Reads a file of the command line; `expected` says what it should be.
fn read_argument(path: &Path, what: &str, expected: &str) -> Result<String, CommandError> {
    read_text(path, MAX_SIDE_FILE_BYTES).map_err(|error| {
        let (exit, help) = match error.kind() {
            std::io::ErrorKind::NotFound => (Exit::BadInput, "check the path".to_owned()),
            _ if is_of_file(&error) => (Exit::BadInput, format!("name {expected}")),
            _ => (Exit::Retryable, ON_FAILED_DISK.to_owned()),
        };
        let what = format!("the {what} {} cannot be read: {error}", shown_path(path));
        CommandError { exit, message: Message::new(what, help) }
    })
}
