//! The results of the runs of a bundle: analyzed afresh, so that they are those of the recordings and of the manifest as it is.

use crate::messages::{Failure, bad};
use clap::{Args as _, Command, FromArgMatches as _};
use data_encoding::BASE64;
use kinetoscope_analysis::cli::AnalyzeArguments;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;

/// Analyzes the recordings of a folder, and returns the names of the results, which are in this folder then. Failed checks are results.
/// The report carries this engine.
pub(super) fn analyze(folder: &Path, engine: &'static [u8]) -> Result<BTreeSet<String>, Failure> {
    // What is in the folder already may be of an earlier manifest, or no result.
    let fresh = tempfile::tempdir().map_err(|error| {
        Failure::new(Exit::Retryable, format!("cannot create a temporary folder: {error}"))
    })?;
    let names_only = [OsStr::new("--no-replay"), OsStr::new("--output"), fresh.path().as_os_str()];
    execute(&[names_only.as_slice(), &[folder.as_os_str()]].concat(), &[])?;
    execute(&[folder.as_os_str()], engine)?;
    let entries = fs::read_dir(fresh.path()).into_iter().flatten().flatten();
    // Not the folder of the cache.
    let files = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    // Not the analysis's own notes either.
    let names: BTreeSet<String> = files
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| !name.starts_with('.'))
        .collect();
    match names.contains(METRICS) {
        true => Ok(names),
        false => Err(bad(format!("the recordings in {} cannot be analyzed", shown_path(folder)))),
    }
}

/// Maximum size of a result.
pub(super) const MAX_RESULT_BYTES: u64 = 256 << 20;

/// The report without its paragraph about the machine, which is another one for a rerun.
pub(super) fn without_machine(report: &str) -> String {
    let (before, rest) = report.split_once("<p class=\"machine").unwrap_or((report, ""));
    let after = rest.split_once("</p>").map_or("", |(_, after)| after);
    format!("{before}{after}")
}

/// The engine in a report, as gzip; empty if it has none.
pub(super) fn engine_in(report: &str) -> Vec<u8> {
    let encoded = report.split_once(ENGINE_START).and_then(|(_, rest)| rest.split_once('"'));
    encoded.and_then(|(text, _)| BASE64.decode(text.as_bytes()).ok()).unwrap_or_default()
}

/// What is before the engine in a report.
const ENGINE_START: &str = "self.kinetoscopeEngine=\"";

/// The page of all results.
pub(super) const REPORT: &str = "report.html";
/// The numbers of all results.
pub(super) const METRICS: &str = "metrics.json";

fn execute(arguments: &[&OsStr], engine: &'static [u8]) -> Result<(), Failure> {
    let name = OsStr::new("analyze");
    // The report of a bundle is one file.
    let options = ["--quiet", "--single-file"].map(OsStr::new);
    let all = [name].into_iter().chain(options).chain(arguments.iter().copied());
    let parsed = AnalyzeArguments::augment_args(Command::new("analyze"))
        .try_get_matches_from(all)
        .and_then(|matches| AnalyzeArguments::from_arg_matches(&matches))
        .map_err(|error| Failure::new(Exit::BadInput, error))?;
    match parsed.execute(engine) {
        Exit::Done | Exit::CheckFailed => Ok(()),
        exit => {
            Err(Failure::new(exit, "the results were not analyzed").help("see the error above"))
        }
    }
}
