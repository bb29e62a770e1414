//! The keys in which two canonical manifests differ.

use kinetoscope_console::text::shortened;
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::fmt;

/// Maximum length of a value that is shown in full.
const LONGEST_VALUE: usize = 60;
/// Maximum length of a value that is stored in full.
const LONGEST_STORED_VALUE: usize = 200;

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
        // A list of positions is too long for a line.
        let short = |value: &String| shortened(value, LONGEST_VALUE).into_owned();
        let shown = |value: &Option<String>| value.as_ref().map_or("(none)".to_owned(), short);
        write!(formatter, "{}: {} → {}", self.key, shown(&self.left), shown(&self.right))
    }
}

/// Returns the keys in which two canonical texts differ: those of the first in its order, then those that only the second
/// has.
#[must_use]
pub fn differing_keys(left: &str, right: &str) -> Vec<KeyDifference> {
    differing_values(keys(left), &keys(right))
}

/// Returns the keys of two manifests that have different values, in the order of [`differing_keys`].
#[must_use]
pub fn differing_values(
    left: Vec<(String, String)>,
    right: &[(String, String)],
) -> Vec<KeyDifference> {
    let by_name =
        |keys: &[(String, String)]| -> BTreeMap<String, String> { keys.iter().cloned().collect() };
    let (in_left, in_right) = (by_name(&left), by_name(right));
    let changed = left.into_iter().filter(|(key, value)| in_right.get(key) != Some(value)).map(
        |(key, value)| KeyDifference { right: in_right.get(&key).cloned(), left: Some(value), key },
    );
    let added = right.iter().filter(|(key, _)| !in_left.contains_key(key)).map(|(key, value)| {
        KeyDifference { key: key.clone(), left: None, right: Some(value.clone()) }
    });
    changed.chain(added).collect()
}

/// Returns the dotted keys of a canonical text with their values as TOML. A value of more than 200 characters, such as a list
/// of positions, is represented by its SHA-256.
#[must_use]
pub fn manifest_values(canonical: &str) -> Vec<(String, String)> {
    let short = |(key, value): (String, String)| {
        if value.len() <= LONGEST_STORED_VALUE {
            return (key, value);
        }
        let hash: String =
            Sha256::digest(value.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
        (key, format!("sha256 {hash}"))
    };
    keys(canonical).into_iter().map(short).collect()
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

#[cfg(test)]
mod tests {
    use super::{differing_values, manifest_values};

    #[test]
    fn long_values_are_compared_by_their_hash() {
        let manifest = |last: &str| {
            let numbers = "0.0, ".repeat(100);
            manifest_values(&format!("seed = 3\n[model.gas]\nx = [{numbers}{last}]\n"))
        };
        let (one, other) = (manifest("1.0"), manifest("2.0"));
        assert_eq!(one[0], ("seed".to_owned(), "3".to_owned()));
        assert!(one[1].1.starts_with("sha256 ") && one[1].1.len() < 80, "{:?}", one[1]);
        assert!(differing_values(one.clone(), &manifest("1.0")).is_empty());
        let differing = differing_values(one, &other);
        assert_eq!(differing.len(), 1);
        assert_eq!(differing[0].key, "model.gas.x");
    }
}
