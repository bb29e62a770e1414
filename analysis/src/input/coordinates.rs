//! Coordinates of runs in a sweep: grouping, names, and derivation from manifests.

use kinetoscope_manifest::Coordinate;
use std::collections::BTreeMap;

/// Formats coordinates, such as "temperature_k = 300, variant = Verlet"; empty for a single run.
pub(crate) fn text(coordinates: &[Coordinate]) -> String {
    let parts = coordinates
        .iter()
        .map(|coordinate| format!("{} = {}", last_part(&coordinate.key), coordinate.value));
    parts.collect::<Vec<_>>().join(", ")
}

/// Formats coordinates for a curve's name: a variant by its name only.
pub(crate) fn label(coordinates: &[Coordinate]) -> String {
    let parts = coordinates.iter().map(|coordinate| match coordinate.key.as_str() {
        "variant" => coordinate.value.clone(),
        key => format!("{} = {}", last_part(key), coordinate.value),
    });
    parts.collect::<Vec<_>>().join(", ")
}

/// Formats coordinates for a file name.
pub(crate) fn file_part(coordinates: &[Coordinate]) -> String {
    let safe = |character: char| {
        if character.is_ascii_alphanumeric() || "._-=".contains(character) {
            character
        } else {
            '_'
        }
    };
    coordinates
        .iter()
        .map(|coordinate| format!("__{}={}", last_part(&coordinate.key), coordinate.value))
        .collect::<String>()
        .chars()
        .map(safe)
        .collect()
}

/// The last part of a dotted key.
pub(crate) fn last_part(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

/// All coordinates except that of a key.
pub(crate) fn without(coordinates: &[Coordinate], key: &str) -> Vec<Coordinate> {
    coordinates.iter().filter(|coordinate| coordinate.key != key).cloned().collect()
}

/// Groups items by coordinates, in order of first appearance.
pub(crate) fn grouped<T>(
    items: impl IntoIterator<Item = (Vec<Coordinate>, T)>,
) -> Vec<(Vec<Coordinate>, Vec<T>)> {
    let mut groups: Vec<(Vec<Coordinate>, Vec<T>)> = Vec::new();
    let mut index: BTreeMap<Vec<(String, String)>, usize> = BTreeMap::new();
    for (coordinates, item) in items {
        let pairs: Vec<(String, String)> = coordinates
            .iter()
            .map(|coordinate| (coordinate.key.clone(), coordinate.value.clone()))
            .collect();
        let at = *index.entry(pairs).or_insert_with(|| {
            groups.push((coordinates, Vec::new()));
            groups.len() - 1
        });
        groups[at].1.push(item);
    }
    groups
}

/// Derives coordinates from canonical manifests: the keys in which they differ, except the replicate and what is
/// recorded.
pub(crate) fn of_manifests(canonical: &[&str]) -> Vec<Vec<Coordinate>> {
    let tables: Vec<BTreeMap<String, String>> = canonical.iter().map(|text| keys(text)).collect();
    let mut differing: Vec<&String> = tables
        .iter()
        .flat_map(BTreeMap::keys)
        .filter(|key| tables.iter().any(|table| table.get(*key) != tables[0].get(*key)))
        .collect();
    differing.sort();
    differing.dedup();
    let of_table = |table: &BTreeMap<String, String>| {
        let coordinate = |key: &&String| {
            let value = table.get(*key)?.clone();
            Some(Coordinate { key: (*key).clone(), value })
        };
        differing.iter().filter_map(coordinate).collect()
    };
    tables.iter().map(of_table).collect()
}

/// The dotted keys of a canonical manifest with their values as text. Long values are represented by their beginning
/// and length.
fn keys(canonical: &str) -> BTreeMap<String, String> {
    let mut table = String::new();
    let mut keys = BTreeMap::new();
    for line in canonical.lines() {
        if let Some(header) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            table = format!("{header}.");
        } else if let Some((key, value)) = line.split_once(" = ") {
            let key = format!("{table}{key}");
            if key != "replicate" && !key.starts_with("record.") {
                keys.insert(key, plain(value));
            }
        }
    }
    keys
}

fn plain(value: &str) -> String {
    let value = value.trim_matches('"');
    match value.strip_suffix(".0").unwrap_or(value) {
        short if short.chars().count() <= 40 => short.to_owned(),
        long => {
            format!("{}… ({} characters)", long.chars().take(24).collect::<String>(), long.len())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn manifests_differ_in_their_coordinates() {
        let manifest = |temperature: &str, replicate: u32| {
            format!(
                "seed = 14\nreplicate = {replicate}\n\n[model.gas]\nparticles = 10\ntemperature_k = {temperature}\n"
            )
        };
        let texts = [manifest("200.0", 0), manifest("373.15", 0), manifest("200.0", 1)];
        let coordinates = of_manifests(&texts.each_ref().map(String::as_str));
        assert_eq!(text(&coordinates[0]), "temperature_k = 200");
        assert_eq!(text(&coordinates[1]), "temperature_k = 373.15");
        assert_eq!(coordinates[0], coordinates[2]);
        assert_eq!(coordinates[0][0].key, "model.gas.temperature_k");
    }
}
