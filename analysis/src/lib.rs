//! Metrics with standard errors, plots and checks, derived from recordings only.
//!
//! Reading order: [`cli`] parses the command line, [`input`] finds the recordings that belong together, [`run`] reads one
//! recording through the observer of its model in [`models`], [`sweep`] combines runs, [`checks`] compares metrics with
//! bounds and baselines, and [`report`] writes the results.
//!
//! [`analyze`] is the way from one recording to its metrics. The modules are internal to the program `analyze-recordings`: they
//! may change in every version.
// The numbers here are derived and never recorded: they need no fixed bits across platforms, so std's maths suffices.
#![allow(clippy::disallowed_methods)]

pub mod checks;
pub mod cli;
pub mod export;
pub mod input;
pub mod metric;
pub mod models;
pub mod plot;
pub mod report;
pub mod run;
pub mod statistics;
pub mod sweep;
pub mod thumbnail;
pub mod write_file;

pub use input::UnreadableRecording;
pub use metric::Measurement;
pub use run::{RunAnalysis, RunStatus};

use kinetoscope_recording::reader::Recording;
use std::thread::available_parallelism;

/// Reads all frames of a recording and derives its metrics.
///
/// # Errors
/// A recording without a readable frame.
pub fn analyze(recording: &Recording) -> Result<RunAnalysis, UnreadableRecording> {
    let run = input::recording::opened(recording.clone())?;
    let threads = available_parallelism().unwrap_or(std::num::NonZeroUsize::MIN);
    run::analyze(&run, Vec::new(), false, &[], threads)
}
