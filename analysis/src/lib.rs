//! Metrics with standard errors, plots and checks, derived from recordings only.
//!
//! Reading order: [`cli`] parses the command line, [`input`] finds the recordings that belong together, [`run`] reads one
//! recording through the observer of its model in `models`, `sweep` combines runs, `checks` compares metrics with
//! bounds and baselines, and `report` writes the results.
//!
//! [`analyze`] is the way from one recording to its metrics. The modules are internal to the program `analyze-recordings`: they
//! may change in every version.

mod answer;
mod checked_experiment;
mod checks;
pub mod cli;
mod export;
pub mod input;
mod metric;
mod metric_files;
mod models;
mod number_text;
mod plot;
mod replay;
mod report;
pub mod run;
mod statistics;
mod sweep;
mod table;
mod thumbnail;
mod write_file;

pub use checked_experiment::{CheckedExperiment, CheckedValue, checked_experiment, value_text};
pub use checks::ci_formats::markdown_text;
pub use input::UnreadableRecording;
pub use metric::{Definition, Law, Measurement, Theory, Violation};
#[cfg(feature = "parquet")]
pub use metric_files::run_row::RunRow;
#[cfg(feature = "parquet")]
pub use metric_files::runs_store::{
    StoreError, StoredOutcome, StoredRun, each_stored_key, each_stored_outcome, each_stored_row,
    row_of_recording, stored_rows, stored_runs, stored_runs_of_keys, write_runs_table,
};
pub use models::{
    figure_names, fitted_along, metric_names, metrics_of_figure, needs_replicates, unit_of,
};
pub use report::{charts_of_run, metrics_reference};
pub use run::{RunAnalysis, RunStatus};
pub use statistics::{Entries, Estimate, MissingError};

use kinetoscope_recording::reader::Recording;
use metric_files::document::Document;
use run::RunOptions;
use std::thread::available_parallelism;

/// Reads all frames of a recording and derives its metrics.
///
/// # Errors
/// A recording without a readable frame.
pub fn analyze(recording: &Recording) -> Result<RunAnalysis, UnreadableRecording> {
    analyze_with(recording, RunOptions::default())
}

/// The same, with what the options ask for.
///
/// # Errors
/// As those of [`analyze`].
pub fn analyze_with(
    recording: &Recording,
    options: RunOptions<'_>,
) -> Result<RunAnalysis, UnreadableRecording> {
    let run = input::recording::opened(recording.clone())?;
    let threads = available_parallelism().unwrap_or(std::num::NonZeroUsize::MIN);
    run::analyze(&run, Vec::new(), options, threads)
}

/// The contents of `metrics.json` for one run, on one line.
///
/// # Errors
/// Errors of the serializer; none is expected.
pub fn metrics_of_run(experiment: &str, run: &RunAnalysis) -> serde_json::Result<String> {
    let metrics: Vec<metric::Metric> = run.metrics().collect();
    serde_json::to_string(&Document::of(experiment, std::slice::from_ref(run), &metrics))
}

/// The metrics that answer first for the model of a run.
#[must_use]
pub fn main_metrics(run: &RunAnalysis) -> &'static [&'static str] {
    models::main_results(run.model()).metrics
}
