//! Sentences of a manifest: the limits of `question` and `answer`, the place of an error in them, and the comment at the start.

use crate::diagnostics::{Diagnostic, Errors};
use crate::tree::{Node, Span, Value};
use crate::value::{TomlValue, quoted, refuse_type};
use serde_json::{Value as Json, json};
use std::ops::Range;

/// Maximum length of a sentence, characters: a question and an answer have about 200.
pub(crate) const LONGEST_SENTENCE: usize = 1000;

/// An error in a part of a text: the part, what is wrong, and what to do.
pub(crate) type Fault = (Range<usize>, String, String);

/// Why a text cannot be the sentence of this key: it is empty, too long, or has a control character.
pub(crate) fn fault_in(key: &str, text: &str) -> Option<Fault> {
    let all = 0..text.len();
    let length = text.chars().count();
    if length > LONGEST_SENTENCE {
        let title = format!("`{key}` has {length} characters");
        return Some((all, title, format!("must have at most {LONGEST_SENTENCE}")));
    }
    if text.trim().is_empty() {
        return Some((all, format!("`{key}` is empty"), "leave it out".to_owned()));
    }
    let is_control = |c: char| c.is_control() && c != '\n';
    let (at, control) = text.char_indices().find(|(_, c)| is_control(*c))?;
    let title = format!("`{key}` contains the control character U+{:04X}", u32::from(control));
    Some((at..at + control.len_utf8(), title, "leave it out".to_owned()))
}

/// Reports an error in a part of a string.
pub(crate) fn report(node: &Node, text: &str, (part, title, label): Fault, errors: &mut Errors) {
    errors.push(Diagnostic::new(title).at(place_in(node, text, part), label));
}

/// The place of a part of a string: all of it if the string contains escapes.
fn place_in(node: &Node, text: &str, part: Range<usize>) -> Span {
    let quotes = (node.span.end - node.span.start).checked_sub(text.len());
    let opening = match quotes {
        Some(2) => 1,
        Some(6) => 3,
        // A line break after the quotes does not count.
        Some(7) => 4,
        _ => return node.span,
    };
    let start = node.span.start + opening;
    Span { start: start + part.start, end: start + part.end, ..node.span }
}

/// Maximum length of the comment that is kept, bytes.
const LONGEST_COMMENT: usize = 2000;

/// The lines of the comment at the start of a manifest, without their signs; a later comment belongs to the keys below it.
pub(crate) fn leading_comment(source: &str) -> String {
    let source = source.trim_start_matches('\u{feff}');
    let lines = source.lines().map_while(|line| line.strip_prefix('#'));
    let mut comment = String::new();
    for line in lines.map(str::trim) {
        if comment.len() + line.len() > LONGEST_COMMENT {
            break;
        }
        if !comment.is_empty() {
            comment.push('\n');
        }
        comment.push_str(line);
    }
    comment
}

/// Separates the question from the expected answer in the first comment.
const EXPECTED: &str = "Expected:";

/// The question in the comment at the start of a manifest: its text up to "Expected:", if that ends with a question mark; else its
/// first line, if that does; else empty.
fn question_in(comment: &str) -> String {
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let before = comment.split(EXPECTED).next().map(words);
    let first = comment.lines().next().map(words);
    let is_question = |text: &String| text.ends_with('?') && fault_in("question", text).is_none();
    before.into_iter().chain(first).find(is_question).unwrap_or_default()
}

/// The question that a manifest states, or that its first comment asks.
pub(crate) fn question(stated: Option<Question>, comment: &str) -> String {
    stated.map_or_else(|| question_in(comment), |question| question.0)
}

/// What an experiment asks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Question(String);

impl TomlValue for Question {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        let Value::Text(text) = &node.value else {
            return refuse_type(node, name, "a string", errors);
        };
        match fault_in(name, text) {
            Some(fault) => {
                report(node, text, fault, errors);
                None
            }
            None => Some(Self(text.clone())),
        }
    }

    fn write(&self) -> String {
        quoted(&self.0)
    }

    fn schema() -> Json {
        json!({ "type": "string", "minLength": 1, "maxLength": LONGEST_SENTENCE })
    }
}
