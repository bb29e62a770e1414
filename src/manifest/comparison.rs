//! The keys in which two canonical manifests differ.

use kinetoscope_console::text::{one_line, shortened};
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
        // A list of positions is too long for a line: it is shown from where the values differ.
        let [left, right] = [&self.left, &self.right].map(|it| it.as_deref().unwrap_or_default());
        let equal = left.chars().zip(right.chars()).take_while(|(one, other)| one == other);
        let before: String = equal.map(|(character, _)| character).collect();
        let begin = before.rfind([' ', '[', '{']).map_or(0, |space| space + 1);
        let is_cut = before.len() >= LONGEST_VALUE / 2;
        let short = |value: &String| match is_cut {
            true => format!("… {}", shortened(&value[begin..], LONGEST_VALUE)),
            false => shortened(value, LONGEST_VALUE).into_owned(),
        };
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

/// Keys of a manifest that affect no run.
const WITHOUT_EFFECT: [&str; 10] = [
    "name",
    "question",
    "answer",
    "description",
    "expected_outcome",
    "checks",
    "plots",
    "view",
    "baseline",
    "exercise",
];
/// Maximum length of a written value that is stored in full.
const LONGEST_WRITTEN_VALUE: usize = 80;

/// Returns the keys that a manifest states and that affect its runs, with their values as TOML. Tables of an array are named after
/// their `name`, or numbered from 1. A value of more than 80 characters is represented by the start of its SHA-256. A text that is no
/// TOML has none.
#[must_use]
pub fn written_values(manifest: &str) -> BTreeMap<String, String> {
    let mut values = BTreeMap::new();
    for (key, value) in manifest.parse::<toml::Table>().unwrap_or_default() {
        if !WITHOUT_EFFECT.contains(&key.as_str()) {
            add_written(key, &value, &mut values);
        }
    }
    values
}

/// Returns the checks that a manifest states, as TOML in the form of this program; empty without any.
#[must_use]
pub fn written_checks(manifest: &str) -> String {
    let table = manifest.parse::<toml::Table>().unwrap_or_default();
    table.get("checks").map(ToString::to_string).unwrap_or_default()
}

fn add_written(key: String, value: &toml::Value, values: &mut BTreeMap<String, String>) {
    match value {
        toml::Value::Table(table) => {
            for (name, value) in table {
                add_written(format!("{key}.{name}"), value, values);
            }
        }
        toml::Value::Array(tables) if tables.iter().any(toml::Value::is_table) => {
            for (index, table) in tables.iter().enumerate() {
                let name = table.get("name").and_then(toml::Value::as_str);
                let name = name.map_or_else(|| (index + 1).to_string(), str::to_owned);
                let mut table = table.clone();
                table.as_table_mut().map(|table| table.remove("name"));
                add_written(format!("{key}[{}]", one_line(&name)), &table, values);
            }
        }
        _ => {
            let mut text = value.to_string().replace('\n', "\\n");
            if text.len() > LONGEST_WRITTEN_VALUE {
                let hash = Sha256::digest(text.as_bytes());
                let start: String = hash.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
                text = format!("sha256 {start}…");
            }
            values.insert(key, text);
        }
    }
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
    use super::{differing_values, manifest_values, written_checks, written_values};

    /// Control: keys without effect on the runs, and another way to write the same number or table.
    #[test]
    fn written_values_are_those_that_affect_the_runs() {
        let manifest = "name = \"x\"\nseed = 3\nanswer = \"{y}\"\n[model.gas]\nparticles = 10\nspeed = 1.50\n\
            [[sweep.variants]]\nname = \"a\"\n\"model.gas.particles\" = 20\n[[checks]]\nmetric = \"y\"\n";
        let found = written_values(manifest);
        let found: Vec<_> = found.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        let expected = [
            "model.gas.particles = 10",
            "model.gas.speed = 1.5",
            "seed = 3",
            "sweep.variants[a].model.gas.particles = 20",
        ];
        assert_eq!(found, expected);
        let [one, other] = [
            "[[checks]]\nmetric = \"y\"\nat_most = 1.0\n",
            "checks = [{ metric=\"y\", at_most=1.00 }]",
        ];
        assert_eq!(written_checks(one), written_checks(other));
        assert_ne!(written_checks(one), written_checks(manifest));
        let long = written_values(&format!("x = [{}1]", "1, ".repeat(100)));
        assert!(long["x"].starts_with("sha256 ") && long["x"].len() < 30, "{}", long["x"]);
    }

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
