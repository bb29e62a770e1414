//! The page that lists several experiments, and the browser that shows a page.

use super::meant_paths::meant_paths;
use super::{AnalyzeArguments, Analyzed};
use crate::report::files::{INDEX, REPORT};
use crate::report::index::{self, Listed};
use crate::write_file::WriteError;
use kinetoscope_console::complain;
use kinetoscope_console::text::shown_path;
use std::path::{Path, PathBuf};

/// Writes `index.html` to each folder of experiments that the user named, or to the one for the results. Returns the folders.
///
/// # Errors
/// The first page that cannot be written.
pub(super) fn write_indexes(
    analyzed: &[Analyzed],
    arguments: &AnalyzeArguments,
) -> Result<Vec<PathBuf>, WriteError> {
    let mut written = Vec::new();
    for folder in index_folders(analyzed, arguments) {
        let listed: Vec<Listed<'_>> = analyzed
            .iter()
            .filter(|one| !one.is_empty() && one.results.starts_with(&folder))
            .map(|one| Listed { report: &one.report, results: &one.results })
            .collect();
        if index::write(&folder, &listed)? {
            written.push(folder);
        } else {
            let path = folder.join(INDEX);
            complain(
                &format!(
                    "note: {} is not from this program; it is not replaced",
                    shown_path(&path)
                ),
                false,
            );
        }
    }
    Ok(written)
}

/// States which reports are not of this analysis, because no recording of their folder can be read.
pub(super) fn name_earlier_reports(analyzed: &[Analyzed]) {
    let (unread, read): (Vec<_>, Vec<_>) = analyzed.iter().partition(|one| one.is_empty());
    for one in unread {
        let report = one.results.join(REPORT);
        if report.exists() && !read.iter().any(|other| other.results == one.results) {
            let report = shown_path(&report);
            complain(
                &format!("note: {report} is of an earlier analysis: no recording can be read"),
                false,
            );
        }
    }
}

/// The folders with results of experiments in folders below.
fn index_folders(analyzed: &[Analyzed], arguments: &AnalyzeArguments) -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> = match &arguments.output {
        Some(output) => vec![output.clone()],
        None => meant_paths(&arguments.paths).unwrap_or_default(),
    };
    folders.sort();
    folders.dedup();
    let has_below = |folder: &PathBuf| {
        let below = |one: &&Analyzed| one.results != *folder && one.results.starts_with(folder);
        analyzed.iter().filter(|one| !one.is_empty()).any(|one| below(&one))
    };
    folders.retain(has_below);
    folders
}

/// Opens the report, or the page that lists several, in the browser. Without a browser, the user learns which file to open.
pub(super) fn open(analyzed: &[Analyzed], arguments: &AnalyzeArguments) {
    let page = match analyzed {
        [one] if !one.is_empty() => one.results.join(REPORT),
        _ => match index_folders(analyzed, arguments)
            .iter()
            .map(|folder| folder.join(INDEX))
            .find(|page| page.exists())
        {
            Some(page) => page,
            None => match analyzed.iter().find(|one| !one.is_empty()) {
                Some(one) => one.results.join(REPORT),
                None => return,
            },
        },
    };
    show(&page);
}

fn show(page: &Path) {
    let absolute = page.canonicalize().unwrap_or_else(|_| page.to_path_buf());
    if let Err(error) = start_browser(&absolute) {
        let name = shown_path(page);
        complain(&format!("note: no browser can be started ({error}): open {name} in one"), false);
    }
}

#[cfg(not(target_family = "wasm"))]
fn start_browser(page: &Path) -> std::io::Result<()> {
    open::that_detached(page)
}

#[cfg(target_family = "wasm")]
fn start_browser(_: &Path) -> std::io::Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}
