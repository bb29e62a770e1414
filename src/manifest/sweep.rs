//! `[sweep]`: one run for each combination of values.

use crate::describe::{self, model_table, record_table};
use crate::diagnostics::{Diagnostic, Errors, nearest};
use crate::keys::{Reader, rules};
use crate::quantity::Finite;
use crate::table::table;
use crate::tree::{Entry, Node, Span, Table, Value};
use crate::value::{TomlValue, refuse_type, shortest, tables, words};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::num::NonZeroU32;

table! {
    /// One direction of a sweep. Paired keys share an axis; named variants are the axis `variant`.
    #[derive(Eq)]
    pub struct Axis {
        /// The dotted keys that change along the axis.
        keys: Vec<String> [""] = Vec::new(),
        /// For each point of the axis the value of each key, in the form of [`Coordinate::value`].
        values: Vec<Vec<String>> [""] = Vec::new(),
    }
}

/// The position of a run on one axis of its sweep.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Coordinate {
    /// The dotted key, or `variant`.
    pub key: String,
    /// The value in its shortest exact form; for long arrays and tables `value-K`, K counting from 1.
    pub value: String,
}

/// The key of the axis defined by `[[sweep.variants]]`.
pub(crate) const VARIANT: &str = "variant";

/// An axis as it is read, with the keys that each of its points sets.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    pub(crate) axis: Axis,
    pub(crate) settings: Vec<Vec<Setting>>,
    place: Span,
}

/// A key and the value that a point of a sweep gives it.
#[derive(Clone, Debug)]
pub(crate) struct Setting {
    pub(crate) key: String,
    pub(crate) key_span: Span,
    pub(crate) node: Node,
}

/// Maximum length of a value in a file name.
const LONGEST_VALUE: usize = 40;
/// Maximum number of keys that a sweep sets; the models have up to 60.
const MOST_KEYS: usize = 1000;
/// Maximum number of points on one axis.
const MOST_POINTS: u32 = 100_000;

words! {
    /// How the values of a range are spaced.
    enum Spacing {
        Linear = "linear",
        Log = "log",
    }
}

/// The keys to which the variants of a sweep give numbers.
pub(crate) fn numbers_of_variants(axes: &[Points]) -> Vec<String> {
    let variants = axes.iter().filter(|points| points.axis.keys.iter().any(|key| key == VARIANT));
    let settings: Vec<&Setting> =
        variants.flat_map(|points| points.settings.iter().flatten()).collect();
    let is_number = |node: &Node| matches!(node.value, Value::Integer(_) | Value::Float(_));
    let mut numbers: Vec<String> = Vec::new();
    for Setting { key, .. } in &settings {
        let mut of_key = settings.iter().filter(|setting| setting.key == *key);
        if !numbers.contains(key) && of_key.all(|setting| is_number(&setting.node)) {
            numbers.push(key.clone());
        }
    }
    numbers
}

/// Reads the table `[sweep]` of runs of a model into its axes, in the order of the file.
pub(crate) fn read(sweep: Option<&Entry>, model: Option<&str>, errors: &mut Errors) -> Vec<Points> {
    let Some(sweep) = sweep else { return Vec::new() };
    let Some(table) = sweep.node.table() else {
        return refuse_type(&sweep.node, "sweep", "a table", errors).unwrap_or_default();
    };
    let mut axes = Vec::new();
    let is_leaf = |_: &str, table: &Table| is_range(table) || table.entries.is_empty();
    for entry in &table.entries {
        match &*entry.key {
            "zip" => {}
            "variants" => axes.extend(variants(&entry.node, errors)),
            key => {
                let entries = entry.leaves(key, &is_leaf).into_iter();
                axes.extend(entries.filter_map(|(key, entry)| swept(&key, entry, model, errors)));
            }
        }
    }
    if sets_too_many_keys(&axes, errors) {
        return Vec::new();
    }
    if let Some(zip) = table.get("zip") {
        pair(&zip.node, &mut axes, errors);
    }
    axes.sort_by_key(|points| points.place);
    refuse_keys_twice(&axes, errors);
    axes
}

fn is_range(table: &Table) -> bool {
    ["from", "to", "count", "spacing"].iter().any(|key| table.get(key).is_some())
}

/// The axis of a key of a model or of `[record]`: a list of values or a range.
fn swept(key: &str, entry: &Entry, model: Option<&str>, errors: &mut Errors) -> Option<Points> {
    let is_empty_table = entry.node.table().is_some_and(|table| table.entries.is_empty());
    let (title, label) = if is_empty_table {
        (format!("the axis `{key}` is empty"), "needs a list or a range".to_owned())
    } else if !key.starts_with("model.") && !key.starts_with("record.") {
        let label = match full_name(key, model) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "keys of [model.*] and [record] can be swept, by their full name".to_owned(),
        };
        (format!("`{key}` cannot be swept"), label)
    } else {
        return axis(key, entry, errors);
    };
    errors.push(Diagnostic::new(title).at(entry.key_span, label));
    None
}

/// The key of a model or of `[record]` that a user meant by its last part.
fn full_name(key: &str, model: Option<&str>) -> Option<String> {
    let key = key.rsplit('.').next().unwrap_or(key);
    let tables = [
        model.map(|model| (format!("model.{model}"), model_table(model))),
        Some(("record".to_owned(), record_table())),
    ];
    tables.into_iter().flatten().find_map(|(path, table)| {
        let known = table["properties"].as_object()?.keys().map(String::as_str);
        nearest(key, known).map(|meant| format!("{path}.{meant}"))
    })
}

fn axis(key: &str, entry: &Entry, errors: &mut Errors) -> Option<Points> {
    let nodes = match &entry.node.value {
        Value::Array(elements) => elements.to_vec(),
        Value::Table(table) => range(key, &entry.node, table, errors)?,
        _ => {
            let expected = "a list [...] or a range { from, to, count, spacing }";
            return refuse_type(&entry.node, &format!("sweep.{key}"), expected, errors);
        }
    };
    if nodes.len() > MOST_POINTS as usize {
        let title = format!("the axis `{key}` has {} values", nodes.len());
        let label = format!("must have at most {MOST_POINTS}");
        errors.push(Diagnostic::new(title).at(entry.node.span, label));
        return None;
    }
    if nodes.is_empty() {
        let title = format!("the axis `{key}` is empty");
        errors.push(Diagnostic::new(title).at(entry.node.span, "needs at least one value"));
        return None;
    }
    let mut values: Vec<Vec<String>> = Vec::with_capacity(nodes.len());
    let mut seen = HashSet::with_capacity(nodes.len());
    for (index, node) in nodes.iter().enumerate() {
        let value = text(node, index);
        if !seen.insert(value.clone()) {
            let title = format!("{value} is listed twice on the axis `{key}`");
            errors.push(
                Diagnostic::new(title)
                    .at(node.span, "each value once; for repetitions use `replicates`"),
            );
        }
        values.push(vec![value]);
    }
    let settings = nodes
        .into_iter()
        .map(|node| vec![Setting { key: key.to_owned(), key_span: entry.key_span, node }])
        .collect();
    let axis = Axis { keys: vec![key.to_owned()], values };
    Some(Points { axis, settings, place: entry.key_span })
}

/// Expands a range `{ from, to, count, spacing }` into its values, the bounds included.
fn range(key: &str, node: &Node, table: &Table, errors: &mut Errors) -> Option<Vec<Node>> {
    let mut reader = Reader::new(&format!("sweep.{key}"), table, errors);
    let from: Option<Finite> = reader.required("from", node.span);
    let to: Option<Finite> = reader.required("to", node.span);
    let count: Option<NonZeroU32> = reader.required("count", node.span);
    let spacing = reader.maybe("spacing").unwrap_or(Spacing::Linear);
    let (from, to) = (from.map(Finite::get), to.map(Finite::get));
    let is_log = matches!(spacing, Spacing::Log);
    rules! { reader;
        count.is_some_and(|count| !(2..=MOST_POINTS).contains(&count.get())) => ["count"]
            "the count of a range is out of range", "must be from 2 to 100000";
        is_log && from.zip(to).is_some_and(|(from, to)| from <= 0.0 || to <= 0.0) => ["from", "to"]
            "a logarithmic range needs bounds > 0", "must be > 0";
    }
    let sound = reader.is_sound();
    reader.finish();
    if !sound {
        // The first value may be known; reading it shows whether key and value fit.
        return from.and_then(|_| table.get("from")).map(|entry| vec![entry.node.clone()]);
    }
    let (from, to, count) = (from?, to?, count?);
    let whole = describe::is_whole(key);
    let points = (0..count.get()).map(|index| {
        let value = between(from, to, index, count.get() - 1, spacing);
        let value = if whole { libm::round(value) } else { value };
        Node { span: node.span, value: Value::Float(value) }
    });
    Some(points.collect())
}

/// Point `index` of a range from point 0 to point `last`; the ends are exact.
fn between(from: f64, to: f64, index: u32, last: u32, spacing: Spacing) -> f64 {
    if index == 0 {
        return from;
    }
    if index == last {
        return to;
    }
    // Weighted ends, so that 0.1 to 0.5 passes through 0.3 and decades through powers of ten.
    let mean = |from: f64, to: f64| {
        (from * f64::from(last - index) + to * f64::from(index)) / f64::from(last)
    };
    match spacing {
        Spacing::Linear => mean(from, to),
        Spacing::Log => libm::exp10(mean(libm::log10(from), libm::log10(to))),
    }
}

/// Reads `[[sweep.variants]]`: sets of keys with a name.
fn variants(node: &Node, errors: &mut Errors) -> Option<Points> {
    let expected = ["tables [[sweep.variants]]", "a table with a name"];
    let mut axis = Axis { keys: vec![VARIANT.to_owned()], values: Vec::new() };
    let mut settings = Vec::new();
    let mut seen = HashSet::new();
    for (element, table) in tables(node, "sweep.variants", expected, errors) {
        let Some(name) = table.get("name") else {
            let error = Diagnostic::new("a variant has no name");
            errors.push(error.at(element.span, "needs `name`"));
            continue;
        };
        let Some(text) = String::read(&name.node, "sweep.variants.name", errors) else { continue };
        if text.trim().is_empty() || !seen.insert(text.clone()) {
            let title = format!("the variant name \"{text}\" is empty or listed twice");
            errors.push(
                Diagnostic::new(title).at(name.node.span, "each variant needs a name of its own"),
            );
        }
        axis.values.push(vec![text]);
        let keys = table.entries.iter().filter(|entry| entry.key != "name");
        settings.push(keys.flat_map(|entry| variant_settings(entry, errors)).collect());
    }
    let place = match &node.value {
        Value::Array(elements) => elements.first().map_or(node.span, |first| first.span),
        _ => node.span,
    };
    (!settings.is_empty()).then_some(Points { axis, settings, place })
}

/// The keys that a key of a variant sets; dotted keys without quotes are followed as long as they name tables.
fn variant_settings(entry: &Entry, errors: &mut Errors) -> Vec<Setting> {
    let depth = match entry.key.split('.').next() {
        Some("model") => 3,
        Some("record") => 2,
        _ => {
            let title = format!("unknown key `{}` in `sweep.variants`", entry.key);
            let label =
                "a variant has a `name` and keys of [model.*] and [record], by their full name";
            errors.push(Diagnostic::new(title).at(entry.key_span, label));
            return Vec::new();
        }
    };
    let leaves = entry.leaves(&entry.key, &|key, _| key.split('.').count() >= depth);
    let setting = |(key, entry): (String, &Entry)| Setting {
        key,
        key_span: entry.key_span,
        node: entry.node.clone(),
    };
    leaves.into_iter().map(setting).collect()
}

/// Reads `zip = [["k1", "k2"]]`, which joins several axes into one.
fn pair(zip: &Node, axes: &mut Vec<Points>, errors: &mut Errors) {
    let Value::Array(groups) = &zip.value else {
        let expected = "a list of lists of swept keys";
        return refuse_type(zip, "sweep.zip", expected, errors).unwrap_or_default();
    };
    for group in groups.iter() {
        let Some(keys) = Vec::<String>::read(group, "sweep.zip", errors) else { continue };
        let mut joined: Option<Points> = None;
        for key in keys {
            let Some(index) = axes.iter().position(|points| points.axis.keys == [key.as_str()])
            else {
                if errors.is_full() {
                    errors.count();
                    continue;
                }
                let swept = axes.iter().flat_map(|points| &points.axis.keys).map(String::as_str);
                let label = match nearest(&key, swept) {
                    Some(meant) => format!("did you mean \"{meant}\"?"),
                    None => "each name must be an axis of [sweep] in one group only".to_owned(),
                };
                let title = format!("`{key}` is not an axis of the sweep");
                errors.push(Diagnostic::new(title).at(group.span, label));
                continue;
            };
            let other = axes.remove(index);
            joined = match joined {
                None => Some(other),
                Some(points) => join(points, other, group, errors),
            };
        }
        axes.extend(joined);
    }
}

/// Pairs two axes of equal length, point by point.
fn join(mut axis: Points, other: Points, group: &Node, errors: &mut Errors) -> Option<Points> {
    if axis.settings.len() != other.settings.len() {
        let title = format!(
            "paired axes differ in length: `{}` has {} values, `{}` has {}",
            axis.axis.keys.join("`, `"),
            axis.settings.len(),
            other.axis.keys.join("`, `"),
            other.settings.len()
        );
        errors.push(Diagnostic::new(title).at(group.span, "paired axes must have equal lengths"));
        return Some(axis);
    }
    if other.place < axis.place {
        axis.place = other.place;
    }
    axis.axis.keys.extend(other.axis.keys);
    for (values, more) in axis.axis.values.iter_mut().zip(other.axis.values) {
        values.extend(more);
    }
    for (settings, more) in axis.settings.iter_mut().zip(other.settings) {
        settings.extend(more);
    }
    Some(axis)
}

/// Whether one dotted key is the other, or a table that contains it.
pub(crate) fn overlap(one: &str, other: &str) -> bool {
    let (short, long) = if one.len() < other.len() { (one, other) } else { (other, one) };
    long.strip_prefix(short).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Reports more keys than any model has, because the time to compare them is quadratic.
fn sets_too_many_keys(axes: &[Points], errors: &mut Errors) -> bool {
    let mut keys = HashSet::new();
    let settings = axes.iter().flat_map(|points| points.settings.iter().flatten());
    for setting in settings {
        keys.insert(setting.key.as_str());
        if keys.len() > MOST_KEYS {
            let title = format!("the sweep sets more than {MOST_KEYS} keys");
            let error = Diagnostic::new(title).at(setting.key_span, "no model has so many");
            errors.push(error);
            return true;
        }
    }
    false
}

/// Reports keys that are set by more than one axis.
fn refuse_keys_twice(axes: &[Points], errors: &mut Errors) {
    let mut seen: Vec<(&str, Span)> = Vec::new();
    for points in axes {
        let (mut own, mut names) = (Vec::new(), HashSet::new());
        for setting in points.settings.iter().flatten() {
            if !names.insert(setting.key.as_str()) {
                continue;
            }
            own.push((setting.key.as_str(), setting.key_span));
            if let Some((_, first)) = seen.iter().find(|(key, _)| overlap(key, &setting.key)) {
                let title = format!("`{}` is swept twice", setting.key);
                let error = Diagnostic::new(title).at(setting.key_span, "one axis for each key");
                errors.push(error.at(*first, ""));
            }
        }
        seen.extend(own);
    }
}

/// A value as it is written in file names and in the `where` of checks.
pub(crate) fn text(node: &Node, index: usize) -> String {
    let text = plain(node);
    if text.is_empty() || text.len() > LONGEST_VALUE {
        format!("value-{}", index + 1)
    } else {
        text
    }
}

fn plain(node: &Node) -> String {
    match &node.value {
        Value::Text(text) => text.clone(),
        Value::Integer(integer) => integer.to_string(),
        Value::Float(number) => {
            let text = shortest(number + 0.0);
            text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
        }
        Value::Boolean(value) => value.to_string(),
        Value::Datetime => "date".to_owned(),
        Value::Array(elements) => elements.iter().map(plain).collect::<Vec<_>>().join("_"),
        Value::Table(table) => {
            let entries = table.entries.iter();
            let parts = entries.map(|entry| format!("{}_{}", entry.key, plain(&entry.node)));
            parts.collect::<Vec<_>>().join("_")
        }
    }
}
