//! `[exercise]`: the answer that a student states, which `kinetoscope grade` compares with a rerun.

use crate::diagnostics::{Diagnostic, Errors};
use crate::keys::{HasKeys as _, Reader};
use crate::quantity::{Finite, NonNegative};
use crate::table::table;
use crate::tree::Entry;
use crate::value::refuse_type;

table! {
    /// The answer to an exercise.
    pub struct Exercise {
        /// Lesson and name of the exercise: `gas_pressure/one_container`.
        name: String [""] = String::new(),
        /// The value that answers the question.
        value: Option<Finite> ["of the answer", optional],
        /// Unit of the value: "1" for a pure number.
        unit: Option<String> ["", optional],
        /// Standard error of the value; 0 for a number without scatter.
        standard_error: Option<NonNegative> ["of the answer", optional],
        /// Hash of the messages of all runs, which `kinetoscope grade --hand-in` writes.
        hash: Option<String> ["", optional],
    }
}

/// Maximum length of a unit, characters.
const LONGEST_UNIT: usize = 20;

/// Reads the table.
pub(crate) fn read(entry: &Entry, errors: &mut Errors) -> Option<Exercise> {
    let Some(table) = entry.node.table() else {
        return refuse_type(&entry.node, "exercise", "a table", errors);
    };
    let mut reader = Reader::new("exercise", table, errors);
    let mut exercise = Exercise::default();
    exercise.keys(&mut reader);
    if !reader.has("name") {
        let error = Diagnostic::new("`exercise.name` is missing");
        reader.report(error.at(entry.node.span, "needs the name of the exercise"));
    } else if !is_exercise_name(&exercise.name) {
        let title =
            "`exercise.name` must be a lesson and a name, such as gas_pressure/one_container";
        reader.refuse(
            &["name"],
            title,
            "up to 40 small letters, digits and _ each, with / between",
        );
    }
    let is_unit = |text: &String| {
        text.chars().count() <= LONGEST_UNIT
            && !text.chars().any(|c| c.is_control() || "<>&".contains(c))
    };
    if exercise.unit.as_ref().is_some_and(|unit| !is_unit(unit)) {
        reader.refuse(
            &["unit"],
            "`exercise.unit` is not a unit",
            "at most 20 characters, without <, > and &",
        );
    }
    reader.finish();
    Some(exercise)
}

/// Whether a text is a lesson and a name: no other path, and nothing that a page or a shell reads otherwise.
fn is_exercise_name(name: &str) -> bool {
    let is_part = |part: &str| {
        (1..=40).contains(&part.len())
            && part.bytes().all(|byte| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_'))
    };
    name.split_once('/').is_some_and(|(lesson, name)| is_part(lesson) && is_part(name))
}
