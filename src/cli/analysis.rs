//! What the command line asks of the analysis, which only the program `kinetoscope` links.

use crate::executor::analyze;
use std::path::PathBuf;

/// The analysis as a program reaches it.
pub trait Analysis {
    /// Analyzes recordings and caches the results next to them, so that a later analysis reads no frame again.
    ///
    /// # Errors
    /// Why not all recordings were analyzed.
    fn cache(&self, recordings: &[PathBuf]) -> Result<(), String>;

    /// Whether runs of a model, or a sweep over them, can have a metric of this name.
    fn lookup(&self, model: &str, metric: &str) -> MetricLookup;
}

/// Result of a search for a metric.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MetricLookup {
    /// The metric exists.
    Known,
    /// No metric has this name; the nearest name, if one is near.
    Unknown(Option<String>),
    /// The program does not know the list of metrics.
    NotLinked,
}

/// The program `analyze-recordings` next to this one: `run-experiment` does not link the analysis.
#[derive(Debug)]
pub struct AnalysisProgram;

impl Analysis for AnalysisProgram {
    fn cache(&self, recordings: &[PathBuf]) -> Result<(), String> {
        analyze::cache(recordings)
    }

    fn lookup(&self, _: &str, _: &str) -> MetricLookup {
        MetricLookup::NotLinked
    }
}
