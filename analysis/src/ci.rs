//! Verdicts in the forms that CI systems read.

use crate::report::Report;
use std::fmt::Write as _;

/// The verdicts of all experiments as JUnit XML: a suite an experiment, a case a verdict, an error a file that can't be read.
#[must_use]
pub fn junit(reports: &[&Report]) -> String {
    let mut text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n".to_owned();
    for report in reports {
        let failed = report.verdicts.iter().filter(|verdict| !verdict.holds).count();
        let errors = report.unreadable.len();
        let name = escaped(&report.name);
        let tests = report.verdicts.len() + errors;
        // Writing to a String can't fail.
        let _ = writeln!(
            text,
            "  <testsuite name=\"{name}\" tests=\"{tests}\" failures=\"{failed}\" errors=\"{errors}\">"
        );
        for verdict in &report.verdicts {
            let subject = escaped(&verdict.subject);
            let finding = escaped(&verdict.finding);
            let _ = write!(text, "    <testcase classname=\"{name}\" name=\"{subject}\"");
            let _ = if verdict.holds {
                writeln!(text, "><system-out>{finding}</system-out></testcase>")
            } else {
                writeln!(text, "><failure message=\"{finding}\"/></testcase>")
            };
        }
        for why in &report.unreadable {
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

/// What failed and what could not be read, as annotations of a GitHub workflow.
#[must_use]
pub fn github(reports: &[&Report]) -> String {
    let mut text = String::new();
    for report in reports {
        for verdict in report.verdicts.iter().filter(|verdict| !verdict.holds) {
            let title = property(&format!("{}: {}", report.name, verdict.subject));
            let _ = writeln!(text, "::error title={title}::{}", data(&verdict.finding));
        }
        for why in &report.unreadable {
            let title = property(&format!("{}: unreadable", report.name));
            let _ = writeln!(text, "::error title={title}::{}", data(why));
        }
    }
    text
}

/// Text between or in the tags of XML and HTML. Characters that XML 1.0 does not know become spaces.
#[must_use]
pub fn escaped(text: &str) -> String {
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

/// The message of an annotation.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// The title of an annotation.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}
