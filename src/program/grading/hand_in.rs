//! Hand-ins: the completed exercise as a manifest of at most 1,024 bytes, with the hash of its runs.

use crate::grading::answer::{Answer, MOST_HAND_IN_BYTES};
use crate::grading::rerun::Rerun;
use crate::messages::exit::of_output;
use crate::messages::{Failure, bad};
use kinetoscope_console::text::shown_path;
use kinetoscope_files::output_file;
use std::path::Path;
use toml::{Table, Value};

/// Keys of a manifest that affect neither the runs nor the answer.
const LEFT_OUT: [&str; 6] = ["question", "answer", "description", "plots", "view", "baseline"];

/// Refuses to replace a file that is not an earlier hand-in of the same exercise.
pub(crate) fn check(answer: &Answer, path: &Path) -> Result<(), Failure> {
    let is_same = |old: Answer| old.hash.is_some() && old.name == answer.name;
    if !path.is_file() || Answer::read_hand_in(path).is_ok_and(is_same) {
        return Ok(());
    }
    let what = format!("{} already exists and is not a hand-in of this exercise", shown_path(path));
    Err(bad(what).help("delete it, or name a new file with --hand-in"))
}

/// Writes the hand-in of an answer.
pub(crate) fn write(answer: &Answer, rerun: &Rerun, path: &Path) -> Result<(), Failure> {
    let mut table: Table = answer.text.parse().unwrap_or_default();
    for key in LEFT_OUT {
        table.remove(key);
    }
    if let Some(exercise) = table.get_mut("exercise").and_then(Value::as_table_mut) {
        exercise.insert("hash".to_owned(), Value::String(rerun.hash.clone()));
    }
    let text = with_exponents(&table, table.to_string());
    if text.len() as u64 > MOST_HAND_IN_BYTES {
        let what = format!(
            "the hand-in has {} bytes; at most {MOST_HAND_IN_BYTES} are graded",
            text.len()
        );
        return Err(bad(what).help("leave out what the exercise does not ask for"));
    }
    output_file::write(path, text.as_bytes()).map_err(|error| {
        let what = format!("cannot write {}: {error}", shown_path(path));
        Failure::new(of_output(&error), what).help("name another file with --hand-in")
    })
}

/// The text of a table in which very small and very large numbers have an exponent in place of many zeros.
fn with_exponents(table: &Table, mut text: String) -> String {
    for value in table.values() {
        text = match value {
            Value::Table(inner) => with_exponents(inner, text),
            Value::Float(number) => {
                text.replace(&format!(" = {value}\n"), &format!(" = {number:?}\n"))
            }
            _ => text,
        };
    }
    text
}
