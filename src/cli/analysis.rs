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
}

/// The program `analyze-recordings` next to this one: `run-experiment` does not link the analysis.
#[derive(Debug)]
pub struct AnalysisProgram;

impl Analysis for AnalysisProgram {
    fn cache(&self, recordings: &[PathBuf]) -> Result<(), String> {
        analyze::cache(recordings)
    }
}
