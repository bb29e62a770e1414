//! Outcomes and check results in the formats of CI systems.

use crate::checks::{CheckKind, CheckResult, one_line};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The outcomes and checks of one experiment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExperimentChecks<'a> {
    /// The experiment's name.
    pub(crate) name: &'a str,
    /// The manifest as it was named, if it is known.
    pub(crate) manifest: Option<&'a str>,
    /// The outcomes of its runs and the results of its checks.
    pub(crate) check_results: &'a [CheckResult],
    /// What could not be read, with reasons.
    pub(crate) unreadable: &'a [String],
}

/// Formats results as JUnit XML: one suite per experiment, one case per run and per check, one error per failed run and per
/// unreadable file.
pub(crate) fn junit(experiments: &[ExperimentChecks<'_>]) -> String {
    let mut text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n".to_owned();
    for experiment in experiments {
        let is_error = |result: &&CheckResult| result.kind == CheckKind::Outcome;
        let failed = || experiment.check_results.iter().filter(|result| !result.passed);
        let errors = experiment.unreadable.len() + failed().filter(is_error).count();
        let failures = failed().count() - failed().filter(is_error).count();
        let name = escaped(experiment.name);
        let tests = experiment.check_results.len() + experiment.unreadable.len();
        let time: f64 =
            experiment.check_results.iter().fold(0.0, |sum, result| sum + result.seconds);
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "  <testsuite name=\"{name}\" tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" time=\"{time:.3}\">"
        );
        let mut uses: BTreeMap<String, usize> = BTreeMap::new();
        for result in experiment.check_results {
            text += &test_case(&name, result, &mut uses);
        }
        for (index, why) in experiment.unreadable.iter().enumerate() {
            let (number, why) = (index + 1, escaped(why));
            let _ = writeln!(
                text,
                "    <testcase classname=\"{name}\" name=\"input {number}\" time=\"0.000\"><error message=\"{why}\"/></testcase>"
            );
        }
        text += "  </testsuite>\n";
    }
    text + "</testsuites>\n"
}

/// One result as a test case. `uses` counts the names, so that each is unique.
fn test_case(suite: &str, result: &CheckResult, uses: &mut BTreeMap<String, usize>) -> String {
    // An XML reader sees line breaks of an attribute as spaces, so names are compared without them.
    let mut name = one_line(&format!("{}: {}", result.subject, result.requirement));
    let count = uses.entry(name.clone()).or_default();
    *count += 1;
    if *count > 1 {
        name = format!("{name} ({count})");
    }
    let (name, finding) = (escaped(&name), escaped(&result.finding));
    let body = match (result.passed, result.kind) {
        (true, _) => format!("<system-out>{finding}</system-out>"),
        (false, CheckKind::Outcome) => format!("<error message=\"{finding}\"/>"),
        (false, _) => format!("<failure message=\"{finding}\"/>"),
    };
    let seconds = result.seconds;
    format!(
        "    <testcase classname=\"{suite}\" name=\"{name}\" time=\"{seconds:.3}\">{body}</testcase>\n"
    )
}

/// Formats failures and unreadable files as annotations of a GitHub workflow, at the line of the check in the manifest.
pub(crate) fn github(experiments: &[ExperimentChecks<'_>]) -> String {
    let mut text = String::new();
    for experiment in experiments {
        let place = |line: u32| match experiment.manifest {
            Some(manifest) => format!("file={},line={},", property(manifest), line.max(1)),
            None => String::new(),
        };
        for result in experiment.check_results.iter().filter(|result| !result.passed) {
            let title = property(&format!("{}: {}", experiment.name, result.subject));
            let (place, finding) = (place(result.line), data(&result.finding));
            let _ = writeln!(text, "::error {place}title={title}::{finding}");
        }
        for why in experiment.unreadable {
            let title = property(&format!("{}: unreadable", experiment.name));
            let _ = writeln!(text, "::error {}title={title}::{}", place(1), data(why));
        }
    }
    text
}

/// Formats all results as Markdown tables, for the summary of a workflow's step.
pub(crate) fn markdown(experiments: &[ExperimentChecks<'_>]) -> String {
    let mut text = String::new();
    for experiment in experiments {
        let _ = writeln!(text, "### {}\n", cell(experiment.name));
        text += "| result | subject | requirement | finding |\n|---|---|---|---|\n";
        for result in experiment.check_results {
            let word = if result.passed { "passed" } else { "**failed**" };
            let [subject, requirement, finding] =
                [&result.subject, &result.requirement, &result.finding].map(|text| cell(text));
            let _ = writeln!(text, "| {word} | {subject} | {requirement} | {finding} |");
        }
        for why in experiment.unreadable {
            let _ = writeln!(text, "| **unreadable** | | | {} |", cell(why));
        }
        text.push('\n');
    }
    text
}

/// Escapes the text of a cell of a Markdown table.
fn cell(text: &str) -> String {
    let text = one_line(text);
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        if matches!(character, '|' | '\\' | '`' | '*' | '_' | '<' | '[') {
            escaped.push('\\');
        }
        escaped.push(character);
    }
    escaped
}

/// Escapes text for XML. Characters that XML 1.0 does not allow become spaces.
pub(crate) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\n' | '\t' => escaped.push(character),
            '\u{fffe}' | '\u{ffff}' => escaped.push(' '),
            control if control.is_control() => escaped.push(' '),
            other => escaped.push(other),
        }
    }
    escaped
}

/// Escapes the message of an annotation.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// Escapes the title of an annotation.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result(subject: &str) -> CheckResult {
        CheckResult {
            passed: false,
            kind: CheckKind::Outcome,
            subject: subject.to_owned(),
            requirement: "completes".to_owned(),
            finding: "a \u{ffff} b\n::error::c".to_owned(),
            line: 0,
            seconds: 0.0,
        }
    }

    /// Names that an XML reader cannot tell apart are numbered, and characters that XML forbids are replaced.
    #[test]
    fn junit_names_are_unique_and_valid_for_any_text() {
        let check_results = ["a\u{1}", "a ", "a\n", "a\u{fffe}"].map(result);
        let xml = junit(&[ExperimentChecks {
            name: "x",
            manifest: None,
            check_results: &check_results,
            unreadable: &[],
        }]);
        for name in ["a : completes", "a : completes (2)", "a : completes (4)"] {
            assert_eq!(xml.matches(&format!("name=\"{name}\"")).count(), 1, "{name} in {xml}");
        }
        assert!(!xml.contains(['\u{1}', '\u{fffe}', '\u{ffff}']), "{xml}");
    }
}
