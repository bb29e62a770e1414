//! Check results in the formats of CI systems.

use crate::checks::CheckResult;
use std::fmt::Write as _;

/// The checks of one experiment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExperimentChecks<'a> {
    /// The experiment's name.
    pub(crate) name: &'a str,
    /// The results of its checks.
    pub(crate) check_results: &'a [CheckResult],
    /// What could not be read, with reasons.
    pub(crate) unreadable: &'a [String],
}

/// Formats check results as JUnit XML: one suite per experiment, one case per result, one error per unreadable file.
pub(crate) fn junit(experiments: &[ExperimentChecks<'_>]) -> String {
    let mut text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n".to_owned();
    for experiment in experiments {
        let failed = experiment.check_results.iter().filter(|result| !result.passed).count();
        let errors = experiment.unreadable.len();
        let name = escaped(experiment.name);
        let tests = experiment.check_results.len() + errors;
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "  <testsuite name=\"{name}\" tests=\"{tests}\" failures=\"{failed}\" errors=\"{errors}\">"
        );
        for result in experiment.check_results {
            let subject = escaped(&result.subject);
            let finding = escaped(&result.finding);
            let _ = write!(text, "    <testcase classname=\"{name}\" name=\"{subject}\"");
            let _ = if result.passed {
                writeln!(text, "><system-out>{finding}</system-out></testcase>")
            } else {
                writeln!(text, "><failure message=\"{finding}\"/></testcase>")
            };
        }
        for why in experiment.unreadable {
            let why = escaped(why);
            let _ = writeln!(
                text,
                "    <testcase classname=\"{name}\" name=\"input\"><error message=\"{why}\"/></testcase>"
            );
        }
        text += "  </testsuite>\n";
    }
    text + "</testsuites>\n"
}

/// Formats failed checks and unreadable files as annotations of a GitHub workflow.
pub(crate) fn github(experiments: &[ExperimentChecks<'_>]) -> String {
    let mut text = String::new();
    for experiment in experiments {
        for result in experiment.check_results.iter().filter(|result| !result.passed) {
            let title = property(&format!("{}: {}", experiment.name, result.subject));
            let _ = writeln!(text, "::error title={title}::{}", data(&result.finding));
        }
        for why in experiment.unreadable {
            let title = property(&format!("{}: unreadable", experiment.name));
            let _ = writeln!(text, "::error title={title}::{}", data(why));
        }
    }
    text
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
