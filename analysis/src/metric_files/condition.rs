//! The condition of `kinetoscope table --where`: comparisons such as `temperature_k > 250, outcome = complete`, which all must hold.

use crate::table::{Cell, CellKind, Column};
use kinetoscope_console::Message;
use kinetoscope_manifest::nearest;
use std::cmp::Ordering;
use std::ops::Range;

/// Comparisons that all must hold; none for all rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Condition {
    text: String,
    comparisons: Vec<Comparison>,
}

#[derive(Clone, Debug, PartialEq)]
struct Comparison {
    column: String,
    column_at: Range<usize>,
    operator: &'static str,
    value: String,
    value_at: Range<usize>,
}

/// A comparison with a column of the table.
pub(crate) struct BoundComparison {
    /// Index of the column.
    pub(crate) column: usize,
    operator: &'static str,
    value: String,
    /// The value as a number, if the column has numbers.
    number: Option<f64>,
}

/// The operators, each before one that it begins with.
const OPERATORS: [&str; 6] = ["!=", "<=", ">=", "<", ">", "="];

/// The rest of a condition, and its place.
struct Scanner<'a> {
    text: &'a str,
    at: usize,
}

impl Scanner<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn skip_blanks(&mut self) {
        let blanks = self.rest().len() - self.rest().trim_start().len();
        self.at += blanks;
    }

    /// Takes a word, or a text in double quotes; empty if there is none.
    fn word(&mut self) -> (String, Range<usize>) {
        self.skip_blanks();
        let start = self.at;
        if let Some((quoted, _)) = self.rest().strip_prefix('"').and_then(|it| it.split_once('"')) {
            let word = quoted.to_owned();
            self.at += word.len() + 2;
            return (word, start..self.at);
        }
        let ends = |character: char| character.is_whitespace() || ",<>=!\"".contains(character);
        let length = self.rest().find(ends).unwrap_or(self.rest().len());
        self.at += length;
        (self.text[start..self.at].to_owned(), start..self.at)
    }

    fn operator(&mut self) -> Option<&'static str> {
        self.skip_blanks();
        let found = OPERATORS.into_iter().find(|operator| self.rest().starts_with(operator))?;
        self.at += found.len();
        Some(found)
    }

    /// Takes `,` or `and`.
    fn conjunction(&mut self) -> bool {
        self.skip_blanks();
        let length = if self.rest().starts_with(',') { 1 } else { 3 };
        let is_one = length == 1
            || self
                .rest()
                .strip_prefix("and")
                .is_some_and(|rest| rest.starts_with(char::is_whitespace));
        if is_one {
            self.at += length;
        }
        is_one
    }
}

impl Condition {
    /// Parses a condition.
    ///
    /// # Errors
    /// What is expected where.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let mut scanner = Scanner { text, at: 0 };
        let mut comparisons = Vec::new();
        let fault = |at: usize, what: &str| fault(text, &(at..at + 1), what);
        loop {
            let (column, column_at) = scanner.word();
            if column.is_empty() {
                return Err(fault(scanner.at, "expected the name of a column"));
            }
            let Some(operator) = scanner.operator() else {
                return Err(fault(scanner.at, "expected =, !=, <, <=, > or >="));
            };
            let (value, value_at) = scanner.word();
            if value_at.is_empty() {
                return Err(fault(scanner.at, "expected a number or a word"));
            }
            comparisons.push(Comparison { column, column_at, operator, value, value_at });
            scanner.skip_blanks();
            if scanner.rest().is_empty() {
                return Ok(Self { text: text.to_owned(), comparisons });
            }
            if !scanner.conjunction() {
                return Err(fault(scanner.at, "expected `,` or `and`"));
            }
        }
    }

    /// The comparisons with the columns of a table.
    ///
    /// # Errors
    /// A name that is no column, or a value that cannot be compared with it.
    pub(crate) fn bound(&self, columns: &[Column]) -> Result<Vec<BoundComparison>, Message> {
        let bound = |comparison: &Comparison| {
            let Comparison { column, column_at, operator, value, value_at } = comparison;
            let found = columns.iter().position(|known| known.name == *column);
            let Some(at) = found else {
                let what = fault(&self.text, column_at, "is no column");
                return Err(Message::new(what, nearest_column(column, columns)));
            };
            let number: Option<f64> = value.parse().ok();
            let is_text = columns[at].kind == CellKind::Text;
            if is_text && !["=", "!="].contains(operator) {
                let what = fault(&self.text, column_at, "has words, which are not ordered");
                return Err(Message::new(what, "compare words with = or !="));
            }
            if !is_text && number.is_none() {
                let what = fault(&self.text, value_at, "is not a number");
                return Err(Message::new(what, format!("`{column}` has numbers")));
            }
            let number = number.filter(|_| !is_text);
            Ok(BoundComparison { column: at, operator, value: value.clone(), number })
        };
        self.comparisons.iter().map(bound).collect()
    }
}

/// Which column may be meant.
pub(crate) fn nearest_column(name: &str, columns: &[Column]) -> String {
    let known = || columns.iter().map(|column| column.name.as_str());
    match nearest(name, known()) {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => {
            format!("the first columns are {}", known().take(12).collect::<Vec<_>>().join(", "))
        }
    }
}

/// What is wrong with a part of the condition, below which there are carets.
fn fault(text: &str, part: &Range<usize>, what: &str) -> String {
    let before = text[..part.start].chars().count();
    let part = text.get(part.clone()).unwrap_or_default();
    let named = if part.trim().is_empty() || what.starts_with("expected") {
        String::new()
    } else {
        format!("`{part}` ")
    };
    let carets = "^".repeat(if named.is_empty() { 1 } else { part.chars().count() });
    format!("--where: {named}{what}\n  | {text}\n  | {}{carets}", " ".repeat(before))
}

impl BoundComparison {
    /// Whether a cell of the column meets the comparison; a missing one does not.
    pub(crate) fn holds(&self, cell: &Cell) -> bool {
        let order = match (cell, self.number) {
            (Cell::Text(text), None) => Some(text.as_str().cmp(&self.value)),
            (Cell::Number(number), Some(value)) => number.partial_cmp(&value),
            (Cell::Integer(number), Some(value)) => (*number as f64).partial_cmp(&value),
            _ => None,
        };
        order.is_some_and(|order| match self.operator {
            "=" => order == Ordering::Equal,
            "!=" => order != Ordering::Equal,
            "<" => order == Ordering::Less,
            "<=" => order != Ordering::Greater,
            ">" => order == Ordering::Greater,
            _ => order != Ordering::Less,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> [Column; 2] {
        [Column::new("temperature_k", CellKind::Number), Column::new("outcome", CellKind::Text)]
    }

    #[test]
    fn comparisons_hold_for_numbers_and_words() {
        let holds = |text: &str, kelvin: f64, outcome: &str| {
            let cells = [Cell::from(kelvin), Cell::from(outcome)];
            let bound = Condition::parse(text).unwrap().bound(&columns()).unwrap();
            bound.iter().all(|comparison| comparison.holds(&cells[comparison.column]))
        };
        for (text, found) in [
            ("temperature_k=300", [false, true, true]),
            ("temperature_k > 250 and outcome = complete", [false, true, false]),
            ("temperature_k>=200,outcome!=\"complete\"", [false, false, true]),
            ("temperature_k<300", [true, false, false]),
            ("temperature_k != 300", [true, false, false]),
            ("temperature_k <= 2e2", [true, false, false]),
        ] {
            let rows = [(200.0, "complete"), (300.0, "complete"), (300.0, "fault")];
            assert_eq!(rows.map(|(kelvin, outcome)| holds(text, kelvin, outcome)), found, "{text}");
        }
        assert!(!holds("temperature_k != 300", f64::NAN, "complete"), "a missing cell");
    }

    #[test]
    fn carets_are_below_the_fault() {
        for (text, what, place) in [
            ("temperature_k 300", "expected =, !=, <, <=, > or >=", "              ^"),
            ("temperature_k >", "expected a number or a word", "               ^"),
            ("a = 1 b = 2", "expected `,` or `and`", "      ^"),
            ("", "expected the name of a column", "^"),
            ("a = 1,", "expected the name of a column", "      ^"),
        ] {
            let expected = format!("--where: {what}\n  | {text}\n  | {place}");
            assert_eq!(Condition::parse(text).unwrap_err(), expected);
        }
        let bound = |text: &str| Condition::parse(text).unwrap().bound(&columns()).err().unwrap();
        let misspelled = bound("outcome = fault, temprature_k = 1");
        let expected = "--where: `temprature_k` is no column\n  | outcome = fault, temprature_k = 1\n  |                  ^^^^^^^^^^^^";
        assert_eq!(misspelled.what, expected);
        assert_eq!(misspelled.help.as_deref(), Some("did you mean `temperature_k`?"));
        assert!(bound("temperature_k = warm").what.contains("`warm` is not a number"));
        assert!(bound("outcome > a").what.contains("not ordered"));
    }
}
