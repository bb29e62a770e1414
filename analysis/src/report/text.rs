//! The report as text for the terminal.

use crate::checks::CheckKind;
use crate::report::AnalysisReport;
use crate::report::table::{Style, Terminal, reasons, table};
use kinetoscope_console::text::one_line;
use std::fmt::Write as _;

/// Number of metrics of a comparison with a baseline in the terminal: at least this many, and all failures up to a maximum; the
/// report contains all.
const MIN_BASELINE_ROWS: usize = 5;
const MAX_BASELINE_ROWS: usize = 20;

impl AnalysisReport {
    /// Formats the report for the terminal.
    pub(crate) fn text(&self, terminal: Terminal) -> String {
        let mut text = String::new();
        let runs = match self.models_and_runs() {
            none if none.is_empty() => "nothing readable".to_owned(),
            some => some,
        };
        let heading = format!("{} ({runs})", one_line(&self.name));
        let _ = writeln!(text, "{}", terminal.paint(Style::Heading, &heading));
        if let Some(headline) = self.headline() {
            let line = terminal.wrapped(&format!("FAILED: {headline}"), 2);
            let _ = writeln!(text, "{}", terminal.paint(Style::Bad, &line));
        }
        for line in [self.question.clone(), self.answer.text()].iter().filter(|it| !it.is_empty()) {
            let _ = writeln!(text, "{}", terminal.wrapped(&one_line(line), 2));
        }
        if !self.description.is_empty() {
            let words: Vec<&str> = self.description.split_whitespace().collect();
            let _ = writeln!(text, "{}", terminal.wrapped(&words.join(" "), 0));
        }
        for note in &self.notes {
            let note = format!("note: {}", one_line(note));
            let _ = writeln!(text, "{}", terminal.wrapped(&note, 2));
        }
        for (title, metrics) in self.sections() {
            let _ = writeln!(text, "\n{}", terminal.wrapped(&one_line(&title), 2));
            if !metrics.is_empty() {
                let _ = writeln!(text, "{}", table(&metrics, terminal));
                let inside = Terminal { width: terminal.width - 2, ..terminal };
                for reason in reasons(&metrics) {
                    let line = format!("  {}", inside.wrapped(&reason, 4));
                    let _ = writeln!(text, "{}", terminal.paint(Style::Faint, &line));
                }
            }
        }
        for (kind, title) in [(CheckKind::Outcome, "outcomes"), (CheckKind::Check, "checks")] {
            text += &self.check_text(kind, title, terminal);
        }
        text + &self.baseline_text(terminal)
    }

    /// Formats the results of one kind. Of outcomes, only failures are listed.
    fn check_text(&self, kind: CheckKind, title: &str, terminal: Terminal) -> String {
        let results = || self.check_results.iter().filter(|result| result.kind == kind);
        let is_silent = kind == CheckKind::Outcome && results().all(|result| result.passed);
        if results().next().is_none() || is_silent {
            return String::new();
        }
        let mut text = format!("\n{title}\n");
        let inside = Terminal { width: terminal.width - 2, ..terminal };
        for result in results().filter(|result| kind == CheckKind::Check || !result.passed) {
            let (style, word) =
                if result.passed { (Style::Good, "ok") } else { (Style::Bad, "FAILED") };
            let line = inside.wrapped(&format!("{word} {}", one_line(&result.text())), 4);
            let _ = writeln!(text, "  {}", line.replacen(word, &terminal.paint(style, word), 1));
        }
        text
    }

    /// Formats the comparison with an earlier analysis: what differs, failures, and the worst metrics.
    fn baseline_text(&self, terminal: Terminal) -> String {
        let Some(comparison) = &self.baseline else { return String::new() };
        let mut text = "\nagainst the baseline\n".to_owned();
        let inside = Terminal { width: terminal.width - 2, ..terminal };
        for rule in &comparison.rules {
            let _ = writeln!(text, "  {}", inside.wrapped(&one_line(rule), 4));
        }
        let mut add = |passed: Option<bool>, subject: &str, finding: &str| {
            let (style, word) = match passed {
                Some(true) => (Style::Good, "ok"),
                Some(false) => (Style::Bad, "FAILED"),
                None => (Style::Faint, "not compared"),
            };
            let line = inside.wrapped(&one_line(&format!("{word} {subject}: {finding}")), 4);
            let _ = writeln!(text, "  {}", line.replacen(word, &terminal.paint(style, word), 1));
        };
        for (subject, finding) in comparison.failures() {
            add(Some(false), subject, finding);
        }
        let compared = || comparison.rows.iter().filter(|row| row.passed.is_some());
        let failed = compared().filter(|row| row.passed == Some(false)).count();
        for row in compared().take(failed.clamp(MIN_BASELINE_ROWS, MAX_BASELINE_ROWS)) {
            add(row.passed, &row.subject, &row.finding());
        }
        let (passed, all) = (compared().count() - failed, comparison.rows.len());
        let not_compared = all - compared().count();
        let line = format!(
            "{passed} of {all} metrics pass, {failed} fail, {not_compared} are not compared; all are in report.html"
        );
        let _ = writeln!(text, "  {}", inside.wrapped(&line, 4));
        for line in comparison.sensitivity_lines() {
            let _ = writeln!(text, "  {}", inside.wrapped(&one_line(line), 4));
        }
        text
    }
}
