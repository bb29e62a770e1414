//! The keys of a table. Each table lists its keys once, in [`HasKeys::keys`]; the visitor decides what a key means:
//! [`Reader`] reads a table, [`Writer`] writes the canonical text, `describe::Describer` builds the schema. The three
//! therefore always agree. The macros in `table` generate the lists.

use crate::diagnostics::{Diagnostic, Errors, nearest};
use crate::tree::{Entry, Node, Span, Table, Value};
use crate::value::TomlValue;
use std::fmt::Display;

/// One key of a table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    /// Its name in the manifest.
    pub(crate) name: &'static str,
    /// Its unit: "1" for a pure number, "" for a word.
    pub(crate) unit: &'static str,
    /// Its meaning, as the schema describes it.
    pub(crate) about: &'static str,
}

/// A visitor of the keys of a table.
pub(crate) trait Keys {
    /// A key that always has a value: at first the default.
    fn key<T: TomlValue>(&mut self, key: &Key, value: &mut T);

    /// A key that may be absent: returns the value read, or `current` where nothing is read.
    fn optional<T: TomlValue>(&mut self, key: &Key, current: Option<T>) -> Option<T>;

    /// A key that the canonical text omits while it has its default.
    fn sparse<T: TomlValue + PartialEq>(&mut self, key: &Key, value: &mut T, default: T) {
        let current = std::mem::replace(value, default);
        let current = (current != *value).then_some(current);
        if let Some(given) = self.optional(key, current) {
            *value = given;
        }
    }

    /// At most one of these keys may be present in the table.
    fn exclusive(&mut self, names: &'static [&'static str]);
}

/// A table, or a part of one, that lists its keys.
pub(crate) trait HasKeys {
    /// Visits the keys in the order of the canonical manifest.
    fn keys(&mut self, keys: &mut impl Keys);
}

/// Keys of the whole manifest that a user may write into a table.
const OF_HEAD: [&str; 5] = ["name", "seed", "replicates", "replicate", "expected_outcome"];

/// Reads one table: known keys into values, everything else into errors.
pub(crate) struct Reader<'a> {
    path: String,
    table: &'a Table,
    /// Other tables of the manifest, whose keys a user may have meant.
    inner: Option<&'a Table>,
    /// Another table by its name, with the keys that belong there.
    elsewhere: Option<(String, Vec<&'static str>)>,
    errors: &'a mut Errors,
    known: Vec<&'static str>,
    failed: Vec<&'static str>,
    breaks_a_rule: bool,
}

impl<'a> Reader<'a> {
    /// Creates a reader of the table at a dotted path; the path of the whole manifest is empty.
    pub(crate) fn new(path: &str, table: &'a Table, errors: &'a mut Errors) -> Self {
        Self {
            path: path.to_owned(),
            table,
            inner: None,
            elsewhere: None,
            errors,
            known: Vec::new(),
            failed: Vec::new(),
            breaks_a_rule: false,
        }
    }

    /// The dotted name of a key of this table.
    fn name(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// The value of a key in the text.
    pub(crate) fn node(&self, key: &str) -> Option<&'a Node> {
        self.table.get(key).map(|entry| &entry.node)
    }

    /// Whether the table has the key.
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
            self.failed.push(key);
            let title = format!("`{}` is missing", self.name(key));
            self.errors.push(Diagnostic::new(title).at(at, format!("needs `{key}`")));
        }
        self.maybe(key)
    }

    /// A key without a unit or a description of its own, as in tables on one line.
    pub(crate) fn maybe<T: TomlValue>(&mut self, key: &'static str) -> Option<T> {
        self.optional(&Key { name: key, unit: "", about: "" }, None)
    }

    /// Reports a broken rule between keys, at those that are present in the table. A key that could not be read breaks no
    /// rule.
    pub(crate) fn refuse(&mut self, keys: &[&str], title: impl Display, label: impl Display) {
        if keys.iter().any(|key| self.failed.contains(key)) {
            return;
        }
        self.breaks_a_rule = true;
        let entries = keys.iter().filter_map(|key| self.table.get(key));
        let places = entries.map(|entry| entry.node.span).collect();
        self.errors.push(Diagnostic::between(title.to_string(), places, label.to_string()));
    }

    /// The same, at the key to change, which need not be the last one in the text.
    pub(crate) fn refuse_at(
        &mut self,
        key: &str,
        keys: &[&str],
        title: impl Display,
        label: impl Display,
    ) {
        match self.node(key) {
            Some(node) => self.refuse_in(node.span, keys, title, label),
            None => self.refuse(keys, title, label),
        }
    }

    /// The same, at a part of a value.
    pub(crate) fn refuse_in(
        &mut self,
        place: Span,
        keys: &[&str],
        title: impl Display,
        label: impl Display,
    ) {
        if keys.iter().any(|key| self.failed.contains(key)) {
            return;
        }
        self.breaks_a_rule = true;
        let others = keys.iter().filter_map(|key| self.table.get(key)).map(|entry| entry.node.span);
        let error = Diagnostic::new(title.to_string()).at(place, label.to_string());
        let error =
            others.filter(|other| *other != place).fold(error, |error, other| error.at(other, ""));
        self.errors.push(error);
    }

    /// Reports an error that has its place already.
    pub(crate) fn report(&mut self, error: Diagnostic) {
        self.errors.push(error);
    }

    /// Whether the table has a key that none of those read so far is.
    pub(crate) fn has_unknown(&self) -> bool {
        self.table.entries.iter().any(|entry| !self.known.contains(&&*entry.key))
    }

    /// Whether all keys were read and no rule is broken so far.
    pub(crate) fn is_sound(&self) -> bool {
        self.failed.is_empty() && !self.breaks_a_rule
    }

    /// Whether further errors are only counted.
    pub(crate) fn is_full(&self) -> bool {
        self.errors.is_full()
    }

    /// Adds keys that are read elsewhere.
    pub(crate) fn also_known(&mut self, names: &[&'static str]) {
        self.known.extend(names);
    }

    /// Suggests keys of other tables, by their dotted names, for unknown keys of this one.
    pub(crate) fn suggest_keys_of(&mut self, tables: &'a Table) {
        self.inner = Some(tables);
    }

    /// Names another table and its keys, for keys that were written into this one.
    pub(crate) fn names_elsewhere(&mut self, table: &str, names: Names) {
        self.elsewhere = Some((table.to_owned(), names.0));
    }

    /// The form of the table, among the keys of all its forms: the one of which most keys are present, else the first with a
    /// key that is like one of the table. Without any, errors name the keys of all forms. Keys of two forms are an error.
    pub(crate) fn form_among(&mut self, forms: &[&[&'static str]]) -> Option<usize> {
        let present = |form: &[&'static str]| -> Vec<&'static str> {
            form.iter().copied().filter(|key| self.has(key)).collect()
        };
        let is_like = |form: &&[&'static str]| {
            let mut entries = self.table.entries.iter();
            entries.any(|entry| nearest(&entry.key, form.iter().copied()).is_some())
        };
        // Of several forms with as many keys, the first.
        let form = (0..forms.len()).rev().max_by_key(|form| present(forms[*form]).len())?;
        let [own, all] = [present(forms[form]), present(&forms.concat())];
        if own.is_empty() {
            let form = forms.iter().position(is_like);
            if form.is_none() {
                self.also_known(&forms[1..].concat());
            }
            return form.or(Some(0));
        }
        let Some(other) = all.iter().find(|key| !own.contains(key)) else { return Some(form) };
        self.also_known(&forms.concat());
        let title = format!("`{}` and `{other}` cannot be used together", self.name(own[0]));
        self.refuse(&all, title, "keep the keys of one of the two");
        None
    }

    /// Reports every unknown key, with the nearest known one.
    pub(crate) fn finish(self) {
        for entry in &self.table.entries {
            if self.known.contains(&&*entry.key) {
                continue;
            }
            if self.errors.is_full() {
                self.errors.count();
                continue;
            }
            let title = if self.path.is_empty() {
                format!("unknown key `{}`", entry.key)
            } else {
                format!("unknown key `{}` in `{}`", entry.key, self.path)
            };
            let near = nearest(&entry.key, self.known.iter().copied()).map(str::to_owned);
            let inner = || self.inner.and_then(|inner| dotted_key(inner, "", &entry.key, 2));
            let is_of_head = !self.path.is_empty() && OF_HEAD.contains(&&*entry.key);
            let elsewhere = self.elsewhere.as_ref().filter(|(_, keys)| keys.contains(&&*entry.key));
            let key = &entry.key;
            let label = match (elsewhere, near.or_else(inner)) {
                (Some((table, _)), _) => format!("write `{key}` below [{table}]"),
                _ if is_of_head => {
                    format!("write `{key}` above the first table, as it belongs to all runs")
                }
                (None, Some(meant)) => format!("did you mean `{meant}`?"),
                _ if key == "packing_fraction" && self.known.contains(&"discs") => {
                    "set `radius`, `width` and `height`: the fraction of N discs is N π radius² / (width height)".to_owned()
                }
                (None, None) => format!("known keys: {}", self.known.join(", ")),
            };
            self.errors.push(Diagnostic::new(title).at(entry.key_span, label));
        }
    }
}

/// Path of the first key of that name in the tables below, down to a depth.
fn dotted_key(table: &Table, path: &str, name: &str, depth: usize) -> Option<String> {
    table.entries.iter().find_map(|entry| {
        let inner = entry.node.table()?;
        let path = format!("{path}{}.", entry.key);
        if inner.get(name).is_some() {
            return Some(format!("{path}{name}"));
        }
        (depth > 1).then(|| dotted_key(inner, &path, name, depth - 1)).flatten()
    })
}

impl Keys for Reader<'_> {
    fn key<T: TomlValue>(&mut self, key: &Key, value: &mut T) {
        if let Some(read) = self.optional(key, None) {
            *value = read;
        }
    }

    fn optional<T: TomlValue>(&mut self, key: &Key, _current: Option<T>) -> Option<T> {
        self.known.push(key.name);
        let node = self.node(key.name)?;
        let read = T::read(node, &self.name(key.name), self.errors);
        if read.is_none() {
            self.failed.push(key.name);
        }
        read
    }

    fn exclusive(&mut self, names: &'static [&'static str]) {
        let present: Vec<&Entry> = names.iter().filter_map(|name| self.table.get(name)).collect();
        if present.len() > 1 {
            let names: Vec<String> =
                present.iter().map(|entry| format!("`{}`", self.name(&entry.key))).collect();
            let title = format!("{} cannot be used together", names.join(" and "));
            let places = present.iter().map(|entry| entry.key_span).collect();
            self.errors.push(Diagnostic::between(title, places, "keep one of them"));
        }
    }
}

/// Reports each rule between keys whose condition holds, which means that it is broken: the keys, what is wrong, and what
/// to do. Both texts are format strings. The error is at the last key in the text, or, with `at KEY of [..]`, at that key.
macro_rules! rules {
    (@ $table:expr, at $at:tt, $($rest:tt)+) => { $table.refuse_at($at, $($rest)+) };
    (@ $table:expr, , $($rest:tt)+) => { $table.refuse($($rest)+) };
    ($table:expr; $($is_broken:expr => $(at $at:tt of)? [$($key:expr),+] $title:literal, $label:literal;)+) => {
        $(if $is_broken {
            $crate::keys::rules!(@ $table, $(at $at)?, &[$($key),+], format_args!($title), format_args!($label));
        })+
    };
}
pub(crate) use rules;

/// Collects the names of keys.
#[derive(Default)]
pub(crate) struct Names(Vec<&'static str>);

impl Names {
    /// Those of a table.
    pub(crate) fn of(table: &mut impl HasKeys) -> Self {
        let mut names = Self::default();
        table.keys(&mut names);
        names
    }
}

impl Keys for Names {
    fn key<T: TomlValue>(&mut self, key: &Key, _value: &mut T) {
        self.0.push(key.name);
    }

    fn optional<T: TomlValue>(&mut self, key: &Key, current: Option<T>) -> Option<T> {
        self.0.push(key.name);
        current
    }

    fn exclusive(&mut self, names: &'static [&'static str]) {
        self.0.extend(names);
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
    fn key<T: TomlValue>(&mut self, key: &Key, value: &mut T) {
        self.text.push_str(&format!("{} = {}\n", key.name, value.write()));
    }

    fn optional<T: TomlValue>(&mut self, key: &Key, current: Option<T>) -> Option<T> {
        current.map(|mut value| {
            self.key(key, &mut value);
            value
        })
    }

    fn exclusive(&mut self, _names: &'static [&'static str]) {}
}
