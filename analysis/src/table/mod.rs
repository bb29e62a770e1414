//! Tables of typed columns, and their text as CSV.

#[cfg(feature = "parquet")]
pub(crate) mod parquet;
#[cfg(feature = "parquet")]
pub(crate) mod parquet_reader;
#[cfg(feature = "parquet")]
mod seal;

use kinetoscope_console::text::visible;

/// The type of a column's cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CellKind {
    /// Text.
    Text,
    /// A whole number: an identifier or a count.
    Integer,
    /// A number.
    Number,
    /// True or false.
    Boolean,
}

/// One cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    /// No value.
    Missing,
    /// Text.
    Text(String),
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// True or false.
    Boolean(bool),
}

/// The name and the type of a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Column {
    /// The name, its unit last.
    pub(crate) name: String,
    /// The type of its cells.
    pub(crate) kind: CellKind,
}

impl Column {
    /// A column.
    pub(crate) fn new(name: impl Into<String>, kind: CellKind) -> Self {
        Self { name: name.into(), kind }
    }

    /// The name as CSV, without control characters.
    pub(crate) fn text(&self) -> String {
        visible(&self.name).into_owned()
    }
}

impl Cell {
    /// The cell as CSV: empty if there is no value, numbers in the shortest form that reads back to the same bits, and text without control
    /// characters, because a terminal may show the file.
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Missing => String::new(),
            Self::Text(text) => visible(text).into_owned(),
            Self::Integer(number) => number.to_string(),
            Self::Number(number) => shortest(*number),
            Self::Boolean(value) => value.to_string(),
        }
    }
}

/// The shortest decimal number that reads back to the same bits.
fn shortest(number: f64) -> String {
    let text = format!("{number:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// A number; missing if it is not finite.
impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        if number.is_finite() { Self::Number(number) } else { Self::Missing }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

/// A count or an identifier; the largest number of the column's type if it exceeds that.
impl From<u64> for Cell {
    fn from(number: u64) -> Self {
        Self::Integer(i64::try_from(number).unwrap_or(i64::MAX))
    }
}

impl From<bool> for Cell {
    fn from(value: bool) -> Self {
        Self::Boolean(value)
    }
}

impl<C: Into<Self>> From<Option<C>> for Cell {
    fn from(value: Option<C>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_read_back_to_the_same_bits() {
        for (number, text) in
            [(300.0, "300"), (0.1, "0.1"), (1e-300, "1e-300"), (-2.5e17, "-2.5e17"), (-0.0, "-0")]
        {
            assert_eq!(Cell::from(number).text(), text);
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), number.to_bits());
        }
        assert_eq!(Cell::from(f64::NAN), Cell::Missing);
        assert_eq!(Cell::from(7_u64).text(), "7");
    }
}
