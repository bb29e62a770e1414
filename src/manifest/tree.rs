//! A TOML text as a tree in which every key and value has its place in the text.

use std::rc::Rc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A range of bytes in one of the texts that were read: the manifest itself or a `--set`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Span {
    /// Which text, in the order of [`crate::diagnostics::Diagnostics`]' sources.
    pub(crate) source: usize,
    /// First byte.
    pub(crate) start: usize,
    /// One past the last byte.
    pub(crate) end: usize,
}

/// A value and its place.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) span: Span,
    pub(crate) value: Value,
}

/// A TOML value. Arrays are shared because a sweep copies the tree for each of its points.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Text(String),
    Integer(i128),
    Float(f64),
    Boolean(bool),
    Datetime,
    Array(Rc<[Node]>),
    Table(Table),
}

/// The keys of a table in the order of the file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    pub(crate) entries: Vec<Entry>,
}

/// A key, its place and its value.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) key: String,
    pub(crate) key_span: Span,
    pub(crate) node: Node,
}

impl Node {
    /// The type of the value, as error messages name it.
    pub(crate) fn what(&self) -> &'static str {
        match self.value {
            Value::Text(_) => "a string",
            Value::Integer(_) => "an integer",
            Value::Float(_) => "a number",
            Value::Boolean(_) => "a boolean",
            Value::Datetime => "a date",
            Value::Array(_) => "an array",
            Value::Table(_) => "a table",
        }
    }

    /// The table, if it is one.
    pub(crate) fn table(&self) -> Option<&Table> {
        match &self.value {
            Value::Table(table) => Some(table),
            _ => None,
        }
    }
}

impl Entry {
    /// The entries at and below this one with their dotted keys, down to those that are no table or satisfy `is_leaf`. TOML
    /// reads dotted keys without quotes as nested tables.
    pub(crate) fn leaves(
        &self,
        key: &str,
        is_leaf: &dyn Fn(&str, &Table) -> bool,
    ) -> Vec<(String, &Self)> {
        match self.node.table() {
            Some(table) if !is_leaf(key, table) => {
                let below = table.entries.iter();
                below
                    .flat_map(|entry| entry.leaves(&format!("{key}.{}", entry.key), is_leaf))
                    .collect()
            }
            _ => vec![(key.to_owned(), self)],
        }
    }
}

impl Table {
    /// The entry of a key.
    pub(crate) fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    /// The entry of a key, taken out.
    pub(crate) fn take(&mut self, key: &str) -> Option<Entry> {
        let index = self.entries.iter().position(|entry| entry.key == key)?;
        Some(self.entries.remove(index))
    }

    /// Inserts a value at a dotted key and creates the tables of the key.
    ///
    /// # Errors
    /// The part of the key that is not a table and so has no keys of its own.
    pub(crate) fn set(&mut self, key: &str, key_span: Span, node: Node) -> Result<(), String> {
        let mut table = self;
        let mut rest = key;
        while let Some((first, after)) = rest.split_once('.') {
            let entry = table.entry(first, key_span, || Value::Table(Self::default()));
            let Value::Table(inner) = &mut entry.node.value else {
                return Err(key[..key.len() - after.len() - 1].to_owned());
            };
            table = inner;
            rest = after;
        }
        let value = node.value.clone();
        let entry = table.entry(rest, key_span, || value);
        entry.key_span = key_span;
        entry.node = node;
        Ok(())
    }

    fn entry(&mut self, key: &str, key_span: Span, value: impl FnOnce() -> Value) -> &mut Entry {
        let index = self.entries.iter().position(|entry| entry.key == key).unwrap_or_else(|| {
            let node = Node { span: key_span, value: value() };
            self.entries.push(Entry { key: key.to_owned(), key_span, node });
            self.entries.len() - 1
        });
        &mut self.entries[index]
    }
}

/// Converts the parser's tree of the text number `source`. `offset` is where that text starts within its source.
///
/// The parser's tree is consumed, so that a large text is not in memory as two whole trees.
pub(crate) fn table(parsed: DeTable<'_>, source: usize, offset: usize) -> Table {
    let mut entries: Vec<Entry> = parsed
        .into_iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().to_string(),
            key_span: span(&key.span(), source, offset),
            node: node(value, source, offset),
        })
        .collect();
    entries.sort_by_key(|entry| entry.key_span);
    Table { entries }
}

/// Converts one value of the parser.
pub(crate) fn node(parsed: Spanned<DeValue<'_>>, source: usize, offset: usize) -> Node {
    let span = span(&parsed.span(), source, offset);
    let value = match parsed.into_inner() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(digits) => match i128::from_str_radix(digits.as_str(), digits.radix()) {
            Ok(integer) => Value::Integer(integer),
            // Too long for any integer: a float instead, which every range of integers rejects.
            Err(_) => Value::Float(digits.as_str().parse().unwrap_or(f64::INFINITY)),
        },
        DeValue::Float(digits) => Value::Float(digits.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(value) => Value::Boolean(value),
        DeValue::Datetime(_) => Value::Datetime,
        DeValue::Array(array) => {
            Value::Array(array.into_iter().map(|element| node(element, source, offset)).collect())
        }
        DeValue::Table(inner) => Value::Table(table(inner, source, offset)),
    };
    Node { span, value }
}

fn span(range: &std::ops::Range<usize>, source: usize, offset: usize) -> Span {
    Span { source, start: range.start + offset, end: range.end + offset }
}
