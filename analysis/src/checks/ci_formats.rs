//! Outcomes and check results in the formats of CI systems.

use crate::checks::baseline::EQUAL;
use crate::checks::{CheckKind, CheckResult};
use crate::input::UnreadableRecording;
use kinetoscope_console::text::{one_line, visible, xml};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The outcomes and checks of one experiment.
#[derive(Clone, Debug)]
pub(crate) struct ExperimentChecks<'a> {
    /// The experiment's name.
    pub(crate) name: &'a str,
    /// The manifest as it was named, if it is known.
    pub(crate) manifest: Option<&'a str>,
    /// The answer to its question in one line; may be empty.
    pub(crate) answer: String,
    /// The outcomes of its runs and the results of its checks.
    pub(crate) check_results: &'a [CheckResult],
    /// What could not be read, with reasons.
    pub(crate) unreadable: &'a [UnreadableRecording],
}

/// Formats results as JUnit XML: one suite per experiment, one case per run and per check, one error per failed run and per
/// unreadable file.
pub(crate) fn junit(experiments: &[ExperimentChecks<'_>]) -> String {
    let mut text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n".to_owned();
    let mut suites = UniqueNames::default();
    for experiment in experiments {
        let is_error = |result: &&CheckResult| result.kind == CheckKind::Outcome;
        let failed = || experiment.check_results.iter().filter(|result| !result.passed);
        let errors = experiment.unreadable.len() + failed().filter(is_error).count();
        let failures = failed().count() - failed().filter(is_error).count();
        // The same experiment in two folders gives two suites.
        let name = xml(&suites.unique(experiment.name.to_owned()));
        let tests = experiment.check_results.len() + experiment.unreadable.len();
        let time: f64 =
            experiment.check_results.iter().fold(0.0, |sum, result| sum + result.seconds);
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "  <testsuite name=\"{name}\" tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" time=\"{time:.3}\">"
        );
        if !experiment.answer.is_empty() {
            let answer = xml(&experiment.answer);
            let _ = writeln!(
                text,
                "    <properties><property name=\"answer\" value=\"{answer}\"/></properties>"
            );
        }
        let mut cases = UniqueNames::default();
        for result in experiment.check_results {
            text += &test_case(&name, result, &mut cases);
        }
        for (index, why) in experiment.unreadable.iter().enumerate() {
            let (number, why) = (index + 1, xml(&why.message.clause()));
            let _ = writeln!(
                text,
                "    <testcase classname=\"{name}\" name=\"input {number}\" time=\"0.000\"><error message=\"{why}\"/></testcase>"
            );
        }
        text += "  </testsuite>\n";
    }
    text + "</testsuites>\n"
}

/// Numbers the repetitions of names.
#[derive(Default)]
struct UniqueNames(BTreeMap<String, usize>);

impl UniqueNames {
    fn unique(&mut self, name: String) -> String {
        let count = self.0.entry(name.clone()).or_default();
        *count += 1;
        if *count > 1 { format!("{name} ({count})") } else { name }
    }
}

/// One result as a test case.
fn test_case(suite: &str, result: &CheckResult, cases: &mut UniqueNames) -> String {
    let subject = result.run.as_ref().unwrap_or(&result.subject);
    let name = format!("{subject}: {}", result.requirement);
    let (name, finding) = (xml(&cases.unique(one_line(&name).into_owned())), xml(&result.finding));
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

/// Formats failures and unreadable files as annotations of a GitHub workflow, at the line of the check in the manifest or the
/// checks file.
pub(crate) fn github(experiments: &[ExperimentChecks<'_>]) -> String {
    let mut text = String::new();
    for experiment in experiments {
        let place = |file: Option<&str>, line: u32| match file.or(experiment.manifest) {
            Some(file) => format!("file={},line={},", property(file), line.max(1)),
            None => String::new(),
        };
        for result in experiment.check_results.iter().filter(|result| !result.passed) {
            let title = property(&format!("{}: {}", experiment.name, result.subject));
            let place = place(result.file.as_deref(), result.line);
            let finding = data(&result.finding);
            let _ = writeln!(text, "::error {place}title={title}::{finding}");
        }
        for why in experiment.unreadable {
            let title = property(&format!("{}: unreadable", experiment.name));
            let _ = writeln!(
                text,
                "::error {}title={title}::{}",
                place(None, 1),
                data(&why.message.clause())
            );
        }
    }
    text
}

/// Formats all results as Markdown tables, for the summary of a workflow's step. Metrics that are equal to a baseline are counted only.
pub(crate) fn markdown(experiments: &[ExperimentChecks<'_>]) -> String {
    let mut text = String::new();
    for experiment in experiments {
        let _ = writeln!(text, "### {}\n", markdown_text(experiment.name));
        if !experiment.answer.is_empty() {
            let _ = writeln!(text, "{}\n", markdown_text(&experiment.answer));
        }
        text += "| result | subject | requirement | finding |\n|---|---|---|---|\n";
        let is_equal = |result: &&CheckResult| result.passed && result.requirement == EQUAL;
        for result in experiment.check_results.iter().filter(|result| !is_equal(result)) {
            let word = if result.passed { "passed" } else { "**failed**" };
            let [subject, requirement, finding] =
                [&result.subject, &result.requirement, &result.finding]
                    .map(|text| markdown_text(text));
            let _ = writeln!(text, "| {word} | {subject} | {requirement} | {finding} |");
        }
        let equal = experiment.check_results.iter().filter(is_equal).count();
        if equal > 0 {
            let _ = writeln!(text, "| passed | {equal} compared metrics | {EQUAL} | |");
        }
        for why in experiment.unreadable {
            let _ =
                writeln!(text, "| **unreadable** | | | {} |", markdown_text(&why.message.clause()));
        }
        text.push('\n');
    }
    text
}

/// Escapes text for a cell of a Markdown table, or a line: no part of it is markup, a mention, a link or a formula.
#[must_use]
pub fn markdown_text(text: &str) -> String {
    let text = one_line(text.trim_start());
    let mut escaped = String::with_capacity(text.len());
    let marker_at = block_marker(&text);
    for (at, character) in text.char_indices() {
        if marker_at == Some(at) {
            escaped.push('\\');
        }
        match character {
            '|' | '\\' | '`' | '*' | '_' | '<' | '[' | '$' | '~' => {
                escaped.extend(['\\', character])
            }
            '&' => escaped += "&amp;",
            // A name or a number after it would be a mention, whether it is escaped or not: https://github.com/github/cmark-gfm/issues/181.
            '@' | '#' => escaped.extend([character, NO_WIDTH]),
            // An address would be a link.
            '/' if text[..at].ends_with(':') => escaped.extend([NO_WIDTH, character]),
            '.' if at >= 3 && text.as_bytes()[at - 3..at].eq_ignore_ascii_case(b"www") => {
                escaped.extend([NO_WIDTH, character]);
            }
            _ => escaped.push(character),
        }
    }
    escaped
}

/// The place of a character with which a line would begin a heading, a list, a quotation, a rule or, in a log of GitHub, a command (`::`); `None` if it
/// does not.
fn block_marker(text: &str) -> Option<usize> {
    let after_digits = text.trim_start_matches(|letter: char| letter.is_ascii_digit());
    let at = text.len() - after_digits.len();
    let mut letters = after_digits.chars();
    let (first, next) = (letters.next()?, letters.next());
    let is_number = || next.is_some_and(|next| next.is_ascii_digit() || next == '.');
    let begins = match (at, first) {
        (0, '#' | '>' | '=') => true,
        (0, ':') => next == Some(':'),
        (0, '-' | '+') => !is_number(),
        (0, _) => false,
        (_, '.' | ')') => next.is_none_or(char::is_whitespace),
        _ => false,
    };
    begins.then_some(at)
}

/// A space without width, which separates what would have a meaning together.
const NO_WIDTH: char = '\u{200b}';

/// Escapes the message of an annotation.
fn data(text: &str) -> String {
    visible(text).replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
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
            run: None,
            requirement: "completes".to_owned(),
            finding: "a \u{ffff} b\n::error::c".to_owned(),
            file: None,
            line: 0,
            seconds: 0.0,
        }
    }

    fn experiment(check_results: &[CheckResult]) -> ExperimentChecks<'_> {
        ExperimentChecks {
            name: "x",
            manifest: None,
            answer: String::new(),
            check_results,
            unreadable: &[],
        }
    }

    /// Repeated names are numbered, and characters that XML forbids are escaped.
    #[test]
    fn junit_names_are_unique_and_valid_for_any_text() {
        let check_results = ["a\u{1}", "a", "a\n", "a", "a\u{fffe}"].map(result);
        let xml = junit(&[experiment(&check_results)]);
        for name in ["a\\u{1}", "a", "a\\n", "a\\u{fffe}"] {
            let name = format!(" name=\"{name}: completes\"");
            assert_eq!(xml.matches(&name).count(), 1, "{name} in {xml}");
        }
        assert_eq!(xml.matches(" name=\"a: completes (2)\"").count(), 1, "{xml}");
        assert!(!xml.contains(['\u{1}', '\u{fffe}', '\u{ffff}']), "{xml}");
        assert!(!xml.lines().any(|line| line.starts_with("::")), "{xml}");
    }

    /// The answer is a property of the suite and a line of the summary, with its characters escaped. Control: without one, neither.
    #[test]
    fn answer_is_in_junit_and_in_the_summary() {
        let answered = ExperimentChecks { answer: "It is <1 | 2>.".to_owned(), ..experiment(&[]) };
        let all = [answered];
        assert!(junit(&all).contains("<property name=\"answer\" value=\"It is &lt;1 | 2&gt;.\"/>"));
        assert!(markdown(&all).contains("\nIt is \\<1 \\| 2>.\n"), "{}", markdown(&all));
        assert!(!junit(&[experiment(&[])]).contains("<prop"));
    }

    /// Source: mentions and references survive backslashes and character references, <https://github.com/github/cmark-gfm/issues/181>.
    /// Control: numbers stay as they are.
    #[test]
    fn markdown_text_is_neither_markup_nor_a_mention_nor_a_link() {
        for (text, expected) in [
            ("::stop-commands::a", "\\::stop-commands::a"),
            ("# All equal", "\\#\u{200b} All equal"),
            ("    - x", "\\- x"),
            ("12. x", "12\\. x"),
            ("> x", "\\> x"),
            ("===", "\\==="),
            ("@all fixes #1", "@\u{200b}all fixes #\u{200b}1"),
            ("https://a.example", "https:\u{200b}//a.example"),
            ("WWW.a.example", "WWW\u{200b}.a.example"),
            ("<img src=x>", "\\<img src=x>"),
            ("![a](b) `c` *d* _e_", "!\\[a](b) \\`c\\` \\*d\\* \\_e\\_"),
            ("-0.5", "-0.5"),
            ("12.5 % 1) 2", "12.5 % 1) 2"),
        ] {
            assert_eq!(markdown_text(text), expected);
        }
    }

    /// The same experiment in two folders gives two suites with different names.
    #[test]
    fn junit_suites_have_unique_names() {
        let xml = junit(&[experiment(&[]), experiment(&[])]);
        for name in ["x", "x (2)"] {
            let suite = format!("<testsuite name=\"{name}\"");
            assert_eq!(xml.matches(&suite).count(), 1, "{name} in {xml}");
        }
    }

    /// An annotation names the file that contains the check.
    #[test]
    fn annotations_name_the_file_of_the_check() {
        let of_manifest = CheckResult { line: 7, ..result("a") };
        let of_file = CheckResult { file: Some("limits.toml".to_owned()), ..of_manifest.clone() };
        let results = [of_manifest, of_file];
        let text = github(&[ExperimentChecks { manifest: Some("x.toml"), ..experiment(&results) }]);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("::error file=x.toml,line=7,"), "{text}");
        assert!(lines[1].starts_with("::error file=limits.toml,line=7,"), "{text}");
    }

    /// An annotation is one line without control characters, whatever the finding contains.
    #[test]
    fn annotations_are_single_lines_of_visible_characters() {
        let text = github(&[experiment(&[result("a\u{1b}\n::stop-commands::x\u{202e}")])]);
        assert_eq!(text.lines().count(), 1, "{text}");
        assert!(!text.contains(['\u{1b}', '\u{202e}']), "{text}");
    }
}
