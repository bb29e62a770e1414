//! Which of several results the question of an experiment asks for.

use super::AnswerSource;
use crate::models::{label_of, unit_of};

/// Letters by which two words are the same, so that "collide" is a word of "collision rate".
const LETTERS: usize = 5;
/// Words that say nothing about a quantity.
const COMMON: [&str; 12] = [
    "that",
    "from",
    "with",
    "this",
    "than",
    "disc",
    "discs",
    "particle",
    "particles",
    "error",
    "change",
    "relative",
];

/// Words of a question and the words of labels that they ask for.
const SYNONYMS: [(&str, &str); 9] = [
    ("cool", "temperature"),
    ("bounce", "restitution"),
    ("leak", "escape"),
    ("leave", "escape"),
    ("grow", "growth"),
    ("hit", "collision"),
    ("drift", "from the exact"),
    ("settl", "at rest"),
    ("stop", "at rest"),
];

/// Whether a quantity with this label and unit is of a kind.
type IsKind = fn(&str, &str) -> bool;

/// Words of questions with the kinds of quantities that they ask for.
const KINDS: [(&str, IsKind); 6] = [
    ("how far", is_distance),
    ("how long", is_time),
    ("longer", is_time),
    ("how soon", is_time),
    ("often", |label, _| label.contains("rate")),
    ("how fast", |label, unit| unit == "m/s" && label.contains("speed")),
];

fn is_distance(label: &str, unit: &str) -> bool {
    unit != "1" && ["distance", "displacement"].iter().any(|word| label.contains(word))
}

fn is_time(label: &str, unit: &str) -> bool {
    ["s", "d"].contains(&unit) && !label.contains("step")
}

/// Number of words of the question that the label of a metric has as well, and whether it is of the kind that the question asks for.
pub(super) fn shared_words(source: &AnswerSource<'_>, metric: &str) -> usize {
    let question = source.record.map_or("", |record| &record.question);
    let (label, unit) = (label_of(metric).unwrap_or_default(), unit_of(metric).unwrap_or_default());
    words_in_common(question, label) + usize::from(is_of_asked_kind(question, label, unit))
}

/// Whether a question asks for a quantity of this kind, such as a distance by "how far".
pub(super) fn is_of_asked_kind(question: &str, label: &str, unit: &str) -> bool {
    let question = question.to_lowercase();
    KINDS.iter().any(|(begin, is_kind)| question.contains(begin) && is_kind(label, unit))
}

/// Beginnings of words that ask whether a quantity changes.
const KEPT: [&str; 6] = ["keep", "conserv", "preserve", "constant", "stay", "unchanged"];

/// Whether a question in lower case asks if a quantity is kept.
pub(super) fn asks_if_kept(question: &str) -> bool {
    words_of(question).any(|word| KEPT.iter().any(|begin| word.starts_with(begin)))
}

/// Whether a question has the last word of a quantity, such as "energy".
pub(super) fn has_last_word(question: &str, quantity: &str) -> bool {
    let last = quantity.split(' ').next_back().unwrap_or_default();
    question.to_lowercase().contains(last.get(..LETTERS).unwrap_or(last))
}

/// Whether the question asks for a time or a rate.
pub(super) fn asks_for_pace(source: &AnswerSource<'_>) -> bool {
    let question = source.record.map_or("", |record| &record.question).to_lowercase();
    ["how fast", "how quick", "how long", "how soon"].iter().any(|begin| question.contains(begin))
}

/// Whether the question is about the order of a method.
pub(super) fn asks_for_order(source: &AnswerSource<'_>) -> bool {
    let question = source.record.map_or("", |record| &record.question).to_lowercase();
    words_of(&question).any(|word| word == "order")
}

fn words_in_common(question: &str, label: &str) -> usize {
    let (question, label) = (question.to_lowercase(), label.to_lowercase());
    let words = |text| words_of(text).filter(|word| word.len() + 1 >= LETTERS);
    let is_in_label = |word: &&str| {
        !COMMON.contains(word)
            && words(&label).any(|other| other.starts_with(word.get(..LETTERS).unwrap_or(word)))
    };
    let is_synonym = |word: &&str| {
        SYNONYMS.iter().any(|(asked, meant)| word.starts_with(asked) && label.contains(meant))
    };
    let is_long = |word: &&str| word.len() + 1 >= LETTERS && is_in_label(word);
    words_of(&question).filter(|word| is_long(word) || is_synonym(word)).count()
}

/// Words of labels by which a question does not name their quantity.
const UNSPECIFIC: [&str; 12] = [
    "start", "mean", "number", "measured", "largest", "least", "relative", "time", "ratio",
    "between", "units", "step",
];

/// Whether the question has all words of a label that say what it is.
pub(super) fn is_named_in_question(source: &AnswerSource<'_>, label: &str) -> bool {
    let question = source.record.map_or("", |record| &record.question);
    names(question, label)
}

fn names(question: &str, label: &str) -> bool {
    let (question, label) = (question.to_lowercase(), label.to_lowercase());
    let begin = |word: &str| word.get(..LETTERS).unwrap_or(word).to_owned();
    let asked: Vec<String> = words_of(&question).map(begin).collect();
    let is_specific = |word: &&str| {
        word.len() + 1 >= LETTERS && !COMMON.contains(word) && !UNSPECIFIC.contains(word)
    };
    let mut words = words_of(&label).filter(is_specific).map(begin).peekable();
    words.peek().is_some() && words.all(|word| asked.contains(&word))
}

pub(super) fn words_of(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| !letter.is_alphabetic())
}

#[cfg(test)]
mod tests {
    use super::{names, words_in_common};

    /// Controls: a part of a name, and a name of words that every question may have.
    #[test]
    fn quantity_is_named_by_all_words_that_say_what_it_is() {
        let question = "What is the packing fraction of the heap?";
        assert!(names(question, "packing fraction"));
        assert!(names("What is its mean speed?", "mean speed"));
        assert!(!names(question, "packing fraction of the bed at the floor"));
        assert!(!names("How many steps does it take?", "time step"));
    }

    /// Control: words that every question about discs has are not counted.
    #[test]
    fn words_of_the_quantity_are_found_in_other_forms() {
        let rate = "collision rate per disc";
        assert_eq!(words_in_common("How often does a disc collide with another one?", rate), 1);
        assert_eq!(words_in_common("How fast does a disc fall?", rate), 0);
        let growth = "relative growth of the semi-major axis";
        assert_eq!(words_in_common("How fast does the orbit grow?", growth), 1);
        assert_eq!(words_in_common("", growth), 0);
        assert_eq!(words_in_common("How does cooling depend on it?", "temperature at the end"), 1);
        assert_eq!(words_in_common("How does cooling depend on it?", rate), 0);
    }
}
