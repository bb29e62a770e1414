//! The report as text for the terminal.

use crate::checks::{CheckKind, CheckResult, subject};
use crate::metric::Metric;
use crate::report::AnalysisReport;
use crate::report::table::{Style, Terminal, reasons, table, table_of_passed};
use crate::sweep::SHARED_STREAMS;
use kinetoscope_console::text::{one_line, plural};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// Number of metrics of a comparison with a baseline in the terminal: at least this many, and all failures up to a maximum; the
/// report contains all.
const MIN_BASELINE_ROWS: usize = 5;
const MAX_BASELINE_ROWS: usize = 20;

/// How much of a report the terminal shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extent {
    /// The answer, the checks and what failed: a screen.
    Brief,
    /// Every metric, every note and every check.
    Whole,
}

/// Number of passed checks in a brief text, and of metrics if there are no checks; all are in the report.
const BRIEF_ROWS: usize = 10;
/// Number of failed checks in a brief text.
const BRIEF_FAILURES: usize = 20;
/// Number of runs without the expected outcome in a brief text.
const BRIEF_OUTCOMES: usize = 4;
/// Number of notes in a brief text.
const BRIEF_NOTES: usize = 3;

impl AnalysisReport {
    /// Formats the report for the terminal.
    pub(crate) fn text(&self, terminal: Terminal, extent: Extent) -> String {
        let is_checked = self.check_results.iter().any(|result| result.kind == CheckKind::Check);
        let mut text = self.head_text(terminal);
        let mut shown = 0;
        if extent == Extent::Whole {
            text += &self.description_text(terminal);
            text += &notes_text(&self.all_notes(), terminal);
            text += &self.metrics_text(terminal, usize::MAX).0;
        } else if !is_checked {
            let (table, rows) = self.metrics_text(terminal, BRIEF_ROWS);
            text += &table;
            shown = rows;
        }
        text += &self.outcome_text(terminal, extent);
        text += &self.check_text(terminal, extent);
        text += &self.baseline_text(terminal);
        if extent == Extent::Brief {
            let notes = notes_text(&self.brief_notes(), terminal);
            if !notes.is_empty() {
                text += "\n";
            }
            text += &notes;
            text += &self.omitted_text(terminal, shown);
        }
        text
    }

    /// Name, failure, question and answer.
    fn head_text(&self, terminal: Terminal) -> String {
        let mut text = String::new();
        let runs = self.models_and_runs();
        if runs.is_empty() {
            // Nothing is readable: the errors say why.
            return text;
        }
        let heading = format!("{} ({runs})", one_line(&self.name));
        let _ = writeln!(text, "{}", terminal.paint(Style::Heading, &heading));
        if let Some(headline) = self.headline() {
            let line = terminal.wrapped(&format!("FAILED: {headline}"), 2);
            let _ = writeln!(text, "{}", terminal.paint(Style::Bad, &line));
        }
        for line in [self.question.clone(), self.answer.text()].iter().filter(|it| !it.is_empty()) {
            let _ = writeln!(text, "{}", terminal.wrapped(&one_line(line), 2));
        }
        text
    }

    fn description_text(&self, terminal: Terminal) -> String {
        let mut text = String::new();
        if !self.description.is_empty() {
            let words: Vec<&str> = self.description.split_whitespace().collect();
            let _ = writeln!(text, "{}", terminal.wrapped(&words.join(" "), 0));
        }
        text
    }

    fn all_notes(&self) -> Vec<&str> {
        self.notes.iter().map(String::as_str).collect()
    }

    /// The first notes of this experiment: none that every sweep has.
    fn brief_notes(&self) -> Vec<&str> {
        let of_experiment = self.notes.iter().filter(|note| *note != SHARED_STREAMS);
        of_experiment.take(BRIEF_NOTES).map(String::as_str).collect()
    }

    /// Formats a table for each section with the number of rows, at most `most` in all.
    fn metrics_text(&self, terminal: Terminal, most: usize) -> (String, usize) {
        let (mut text, mut shown) = (String::new(), 0);
        for (title, mut metrics) in self.sections() {
            metrics.truncate(most - shown);
            if most == shown {
                break;
            }
            shown += metrics.len();
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
        (text, shown)
    }

    /// Lists the runs that ended otherwise than expected.
    fn outcome_text(&self, terminal: Terminal, extent: Extent) -> String {
        let outcomes = self.check_results.iter().filter(|it| it.kind == CheckKind::Outcome);
        let failed: Vec<&CheckResult> = outcomes.filter(|result| !result.passed).collect();
        if failed.is_empty() {
            return String::new();
        }
        let most = if extent == Extent::Brief { BRIEF_OUTCOMES } else { failed.len() };
        let lines = failed.iter().take(most).map(|result| result_line(result, terminal));
        let mut text = format!("\noutcomes\n{}", lines.collect::<String>());
        if failed.len() > most {
            let _ = writeln!(text, "  and {} more: --all prints them", failed.len() - most);
        }
        text
    }

    /// Formats the checks: each in a line, or in brief those that fail and a table of those that pass.
    fn check_text(&self, terminal: Terminal, extent: Extent) -> String {
        let checks = self.check_results.iter().filter(|it| it.kind == CheckKind::Check);
        let checks: Vec<&CheckResult> = checks.collect();
        if checks.is_empty() {
            return String::new();
        }
        if extent == Extent::Whole {
            let lines = checks.iter().map(|result| result_line(result, terminal));
            return format!("\nchecks\n{}", lines.collect::<String>());
        }
        let (passed, failed): (Vec<&CheckResult>, Vec<&CheckResult>) =
            checks.iter().partition(|result| result.passed);
        let count = |number: usize, of: usize, word: &str| match number {
            all if all == of => format!("{} {word}", plural(of as u64, "check")),
            number => format!("{number} of {} {word}", plural(of as u64, "check")),
        };
        let mut counts = Vec::new();
        if !failed.is_empty() {
            counts.push(count(failed.len(), checks.len(), "failed"));
        }
        if !passed.is_empty() {
            counts.push(count(passed.len(), checks.len(), "passed"));
        }
        let mut text = format!("\n{}\n", counts.join(", "));
        let lines = failed.iter().take(BRIEF_FAILURES);
        text.extend(lines.map(|result| result_line(result, terminal)));
        if !passed.is_empty() {
            // Means over replicates precede the runs that they are of.
            let mut metrics: BTreeMap<String, &Metric> = BTreeMap::new();
            for metric in &self.metrics {
                metrics.entry(subject(metric)).or_insert(metric);
            }
            let rows: Vec<(&CheckResult, Option<&Metric>)> = passed
                .iter()
                .take(BRIEF_ROWS)
                .map(|result| (*result, metrics.get(&result.subject).copied()))
                .collect();
            let _ = writeln!(text, "{}", table_of_passed(&rows, terminal));
        }
        text
    }

    /// Says in one line what a brief text omits. It has `shown` metrics in addition to those with a check.
    fn omitted_text(&self, terminal: Terminal, shown: usize) -> String {
        let checked: BTreeSet<&str> = self
            .check_results
            .iter()
            .filter(|result| result.kind == CheckKind::Check)
            .map(|result| result.subject.as_str())
            .collect();
        let metrics = self.sections().iter().map(|(_, metrics)| metrics.len()).sum::<usize>();
        let omitted = metrics.saturating_sub(shown + checked.len());
        let notes = self.notes.len() - self.brief_notes().len();
        let parts = [(omitted, "other number"), (notes, "note")];
        let parts: Vec<String> = parts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| plural(*count as u64, what))
            .collect();
        if parts.is_empty() {
            return String::new();
        }
        let line = format!("--all prints {} as well", parts.join(" and "));
        format!("\n{}\n", terminal.paint(Style::Faint, &terminal.wrapped(&line, 2)))
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

fn notes_text(notes: &[&str], terminal: Terminal) -> String {
    let line = |note: &&str| terminal.wrapped(&format!("note: {}", one_line(note)), 2) + "\n";
    notes.iter().map(line).collect()
}

/// Formats the result of a check in a line.
fn result_line(result: &CheckResult, terminal: Terminal) -> String {
    let inside = Terminal { width: terminal.width - 2, ..terminal };
    let (style, word) = if result.passed { (Style::Good, "ok") } else { (Style::Bad, "FAILED") };
    let line = inside.wrapped(&format!("{word} {}", one_line(&result.text())), 4);
    format!("  {}\n", line.replacen(word, &terminal.paint(style, word), 1))
}
