//! The keys in which two canonical manifests differ.

use std::collections::BTreeMap;
use std::fmt;

/// Maximum length of a value that is shown in full.
const LONGEST_VALUE: usize = 60;

/// A key that has another value in another manifest, or is missing there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyDifference {
    /// The dotted key, such as `model.gas.particles`.
    pub key: String,
    /// Its value as TOML in the first manifest; `None` where it has no such key.
    pub left: Option<String>,
    /// Its value in the second.
    pub right: Option<String>,
}

/// `seed: 3 → 4`.
impl fmt::Display for KeyDifference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = |value: &Option<String>| value.as_deref().map_or("(none)".to_owned(), short);
        write!(formatter, "{}: {} → {}", self.key, shown(&self.left), shown(&self.right))
    }
}

/// Shortens a value that is too long for a line, such as a list of positions.
fn short(value: &str) -> String {
    match value.char_indices().nth(LONGEST_VALUE) {
        Some((end, _)) => format!("{}…", &value[..end]),
        None => value.to_owned(),
    }
}

/// Returns the keys in which two canonical texts differ: those of the first in its order, then those that only the second
/// has.
#[must_use]
pub fn differing_keys(left: &str, right: &str) -> Vec<KeyDifference> {
    let (left, right) = (keys(left), keys(right));
    let by_name =
        |keys: &[(String, String)]| -> BTreeMap<String, String> { keys.iter().cloned().collect() };
    let (in_left, in_right) = (by_name(&left), by_name(&right));
    let changed = left.into_iter().filter(|(key, value)| in_right.get(key) != Some(value)).map(
        |(key, value)| KeyDifference { right: in_right.get(&key).cloned(), left: Some(value), key },
    );
    let added = right.iter().filter(|(key, _)| !in_left.contains_key(key)).map(|(key, value)| {
        KeyDifference { key: key.clone(), left: None, right: Some(value.clone()) }
    });
    changed.chain(added).collect()
}

/// The dotted keys of a canonical text with their values. It has one key per line, below the header of its table.
fn keys(canonical: &str) -> Vec<(String, String)> {
    let mut table = String::new();
    let mut keys = Vec::new();
    for line in canonical.lines() {
        if let Some(header) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            table = format!("{header}.");
        } else if let Some((key, value)) = line.split_once(" = ") {
            keys.push((format!("{table}{key}"), value.to_owned()));
        }
    }
    keys
}
