//! The contents of `metrics.json`, and their comparison with those of an earlier analysis.

use super::AnalysisReport;
use crate::checks::CheckKind;
use crate::checks::baseline::Baseline;
use crate::metric_files::document::{CheckEntry, Document, MOST_RUNS};

impl AnalysisReport {
    /// The contents of `metrics.json`.
    pub(crate) fn document(&self) -> Document {
        let (question, answer) = (self.question.clone(), self.answer.entry());
        let mut checks = Vec::new();
        if self.runs.len() > MOST_RUNS {
            let stated = self.check_results.iter().filter(|it| it.kind == CheckKind::Check);
            checks.extend(stated.map(|result| CheckEntry {
                subject: result.subject.clone(),
                passed: result.passed,
                finding: result.finding.clone(),
            }));
        }
        let document = Document::of(&self.name, &self.runs, &self.metrics);
        Document { question, answer, checks, ..document }
    }

    /// Compares the metrics with those of an earlier analysis. Keys that are `allowed` may differ.
    ///
    /// # Errors
    /// A key in `allowed` that no manifest has, and more than [`MOST_RUNS`] runs.
    pub(crate) fn compare(
        &mut self,
        baseline: &Baseline,
        allowed: &[String],
    ) -> Result<(), String> {
        if self.runs.len() > MOST_RUNS {
            return Err(format!(
                "metrics are compared run by run, up to {MOST_RUNS} runs; this experiment has {}",
                self.runs.len()
            ));
        }
        let document = self.document();
        let comparison =
            baseline.compare(&self.metrics, &document, &self.runs, &self.tolerances, allowed)?;
        self.check_results.extend(comparison.check_results());
        self.baseline = Some(comparison);
        Ok(())
    }
}
