//! The keys of a table. Each table names its keys once, in a function `keys`; whoever walks them decides what that
//! means: [`Reader`] reads a table, [`Writer`] writes the canonical text, `schema::Describer` makes the schema. So
//! the three cannot fall out of step.

use crate::diagnostics::{Diagnostic, nearest};
use crate::tree::{Entry, Node, Span, Table, Value};
use crate::value::TomlValue;

/// Who walks the keys of a table.
pub(crate) trait Keys {
    /// A key with its unit ("1" for a pure number, "" for words), what it means, and its value, at first the default.
    fn key<T: TomlValue>(
        &mut self,
        name: &'static str,
        unit: &'static str,
        about: &'static str,
        value: &mut T,
    );

    /// A key that may be absent: `Some` if it was read, or what the writer was given.
    fn optional<T: TomlValue>(
        &mut self,
        name: &'static str,
        unit: &'static str,
        about: &'static str,
        current: Option<T>,
    ) -> Option<T>;

    /// Of these keys at most one may stand in the table.
    fn exclusive(&mut self, names: &'static [&'static str]);
}

/// Reads one table: known keys into values, everything else into errors.
pub(crate) struct Reader<'a> {
    path: String,
    table: &'a Table,
    errors: &'a mut Vec<Diagnostic>,
    known: Vec<&'static str>,
    failed: Vec<&'static str>,
}

impl<'a> Reader<'a> {
    /// A reader of the table that stands at a dotted path; the path of the whole manifest is empty.
    pub(crate) fn new(path: &str, table: &'a Table, errors: &'a mut Vec<Diagnostic>) -> Self {
        Self { path: path.to_owned(), table, errors, known: Vec::new(), failed: Vec::new() }
    }

    /// The dotted name of a key of this table.
    fn name(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// The value of a key, as it stands in the text.
    pub(crate) fn node(&self, key: &str) -> Option<&'a Node> {
        self.table.get(key).map(|entry| &entry.node)
    }

    /// Whether the key stands in the table.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.table.get(key).is_some()
    }

    /// The value of a key, if it is a string.
    pub(crate) fn text(&self, key: &str) -> Option<&'a str> {
        match &self.node(key)?.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// A key without which the table makes no sense; its absence is reported at `at`.
    pub(crate) fn required<T: TomlValue>(&mut self, key: &'static str, at: Span) -> Option<T> {
        if !self.has(key) {
            let title = format!("`{}` is missing", self.name(key));
            self.errors.push(Diagnostic::new(title).at(at, format!("needs `{key}`")));
        }
        self.optional(key, "", "", None)
    }

    /// Reports a rule between keys, at those of them that stand in the table. A key that could not be read breaks no rule.
    pub(crate) fn refuse(&mut self, keys: &[&str], title: &str, label: &str) {
        if keys.iter().any(|key| self.failed.contains(key)) {
            return;
        }
        let entries = keys.iter().filter_map(|key| self.table.get(key));
        let places = entries.map(|entry| entry.node.span).collect();
        self.errors.push(Diagnostic::between(title, places, label));
    }

    /// Reports an error that knows its place already.
    pub(crate) fn report(&mut self, error: Diagnostic) {
        self.errors.push(error);
    }

    /// Whether no key of this table failed so far.
    pub(crate) fn is_sound(&self) -> bool {
        self.failed.is_empty()
    }

    /// Keys that somebody else reads.
    pub(crate) fn also_known(&mut self, names: &[&'static str]) {
        self.known.extend(names);
    }

    /// Refuses every key that was not asked for, with the nearest one that was.
    pub(crate) fn finish(self) {
        for entry in &self.table.entries {
            if self.known.contains(&&*entry.key) {
                continue;
            }
            let title = if self.path.is_empty() {
                format!("unknown key `{}`", entry.key)
            } else {
                format!("unknown key `{}` in `{}`", entry.key, self.path)
            };
            let label = match nearest(&entry.key, self.known.iter().copied()) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => format!("known keys: {}", self.known.join(", ")),
            };
            self.errors.push(Diagnostic::new(title).at(entry.key_span, label));
        }
    }
}

impl Keys for Reader<'_> {
    fn key<T: TomlValue>(
        &mut self,
        name: &'static str,
        unit: &'static str,
        about: &'static str,
        value: &mut T,
    ) {
        if let Some(read) = self.optional(name, unit, about, None) {
            *value = read;
        }
    }

    fn optional<T: TomlValue>(
        &mut self,
        name: &'static str,
        _unit: &'static str,
        _about: &'static str,
        _current: Option<T>,
    ) -> Option<T> {
        self.known.push(name);
        let node = self.node(name)?;
        let read = T::read(node, &self.name(name), self.errors);
        if read.is_none() {
            self.failed.push(name);
        }
        read
    }

    fn exclusive(&mut self, names: &'static [&'static str]) {
        let present: Vec<&Entry> = names.iter().filter_map(|name| self.table.get(name)).collect();
        if present.len() > 1 {
            let names: Vec<String> =
                present.iter().map(|entry| format!("`{}`", self.name(&entry.key))).collect();
            let title = format!("{} exclude each other", names.join(" and "));
            let places = present.iter().map(|entry| entry.key_span).collect();
            self.errors.push(Diagnostic::between(title, places, "keep one of them"));
        }
    }
}

/// Writes a table in canonical form: every key that has a value, in the order of its declaration.
#[derive(Default)]
pub(crate) struct Writer {
    /// The text so far.
    pub(crate) text: String,
}

impl Writer {
    /// Begins a table.
    pub(crate) fn header(&mut self, path: &str) {
        self.text.push_str(&format!("\n[{path}]\n"));
    }
}

impl Keys for Writer {
    fn key<T: TomlValue>(
        &mut self,
        name: &'static str,
        _unit: &'static str,
        _about: &'static str,
        value: &mut T,
    ) {
        self.text.push_str(&format!("{name} = {}\n", value.write()));
    }

    fn optional<T: TomlValue>(
        &mut self,
        name: &'static str,
        unit: &'static str,
        about: &'static str,
        current: Option<T>,
    ) -> Option<T> {
        current.map(|mut value| {
            self.key(name, unit, about, &mut value);
            value
        })
    }

    fn exclusive(&mut self, _names: &'static [&'static str]) {}
}
