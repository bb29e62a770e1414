//! Coordinates of runs in a sweep: grouping, names, and derivation from manifests.

use super::key_words::words_and_unit;
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::Coordinate;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// The key of variants with names.
pub(crate) const VARIANT: &str = "variant";

/// The value of a coordinate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum CoordinateValue {
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// A word, the name of a variant, or a value that is not a number.
    Text(String),
}

impl fmt::Display for CoordinateValue {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(number) => number.fmt(formatter),
            Self::Number(number) => number.fmt(formatter),
            Self::Text(text) => text.fmt(formatter),
        }
    }
}

/// The value of a coordinate: a number if it is one.
pub(crate) fn value_of(coordinate: &Coordinate) -> CoordinateValue {
    let text = &coordinate.value;
    let is_written_as_number =
        text.starts_with(|first: char| first.is_ascii_digit() || first == '-');
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    match (text.parse(), number) {
        _ if coordinate.key == VARIANT || !is_written_as_number => {
            CoordinateValue::Text(text.clone())
        }
        (Ok(integer), _) => CoordinateValue::Integer(integer),
        (_, Some(number)) => CoordinateValue::Number(number),
        _ => CoordinateValue::Text(text.clone()),
    }
}

/// The keys of all coordinates, in the order of the sweep.
pub(crate) fn keys_of<'a>(all: impl IntoIterator<Item = &'a [Coordinate]>) -> Vec<String> {
    let mut keys: Vec<String> = Vec::new();
    for coordinate in all.into_iter().flatten() {
        if !keys.contains(&coordinate.key) {
            keys.push(coordinate.key.clone());
        }
    }
    keys
}

/// The names of a sweep's axes: the last part of a key, or the whole key where two keys have the same last part.
#[derive(Debug)]
pub(crate) struct AxisNames {
    /// Keys with their names, in the order of the sweep.
    names: Vec<(String, String)>,
}

impl AxisNames {
    /// The names of the axes of these coordinates.
    pub(crate) fn of<'a>(all: impl IntoIterator<Item = &'a [Coordinate]>) -> Self {
        let keys = keys_of(all);
        let is_unique =
            |key: &str| keys.iter().filter(|other| last_part(other) == last_part(key)).count() == 1;
        let name = |key: &String| if is_unique(key) { last_part(key) } else { key }.to_owned();
        Self { names: keys.iter().map(|key| (key.clone(), name(key))).collect() }
    }

    /// Each key with its name.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.names.iter().map(|(key, name)| (key.as_str(), name.as_str()))
    }

    /// The name of a key.
    pub(crate) fn name<'a>(&'a self, key: &'a str) -> &'a str {
        self.iter().find(|(other, _)| *other == key).map_or(key, |(_, name)| name)
    }
}

/// The value of a coordinate as it is shown: a vector, which sweeps and file names contain as `0_-9.81`, in parentheses.
pub(crate) fn shown_value(coordinate: &Coordinate) -> String {
    let value = &coordinate.value;
    let parts = value.split('_');
    let is_number = |part: &str| part.parse().is_ok_and(f64::is_finite);
    if coordinate.key != VARIANT
        && matches!(parts.clone().count(), 2 | 3)
        && parts.clone().all(is_number)
    {
        return format!("({})", parts.collect::<Vec<_>>().join(", "));
    }
    match value.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
        Some(parts) => format!("({})", parts.split(", ").map(plain).collect::<Vec<_>>().join(", ")),
        None => value.clone(),
    }
}

/// Formats coordinates, such as "temperature_k = 300, variant = Verlet"; empty for a single run.
pub(crate) fn text(coordinates: &[Coordinate]) -> String {
    let parts = coordinates
        .iter()
        .map(|coordinate| format!("{} = {}", last_part(&coordinate.key), shown_value(coordinate)));
    parts.collect::<Vec<_>>().join(", ")
}

/// The value of a coordinate that is not a number, for a reader: a word of a key, such as `uniform-in-area`, without its hyphens.
pub(crate) fn word(coordinate: &Coordinate) -> String {
    let value = one_line(&shown_value(coordinate)).into_owned();
    if coordinate.key == VARIANT { value } else { value.replace('-', " ") }
}

/// Formats coordinates for a reader, in one line: keys in words, numbers with their units, and a variant by its name only, such as
/// "time step = 0.25 days, RK4".
pub(crate) fn label(coordinates: &[Coordinate]) -> String {
    let parts = coordinates.iter().map(|coordinate| match coordinate.key.as_str() {
        VARIANT => coordinate.value.clone(),
        key => {
            let ((words, unit), value) = (words_and_unit(last_part(key)), shown_value(coordinate));
            let unit = if value == "1" && unit == "days" { "day" } else { unit };
            let is_number = value.starts_with('(') || value.parse::<f64>().is_ok();
            let (value, unit) = if is_number { (value, unit) } else { (word(coordinate), "") };
            format!("{words} = {value} {unit}").trim_end().to_owned()
        }
    });
    one_line(&parts.collect::<Vec<_>>().join(", ")).into_owned()
}

/// Maximum length of the coordinates in a file name; file systems allow 255 bytes, and plots have stems of up to 60.
const LONGEST_FILE_PART: usize = 160;

/// Formats coordinates for a file name. Of those that are too long, only the beginning is kept, and a hash of all of them.
pub(crate) fn file_part(coordinates: &[Coordinate]) -> String {
    let safe = |character: char| {
        if character.is_ascii_alphanumeric() || "._-=".contains(character) {
            character
        } else {
            '_'
        }
    };
    let text: String = coordinates
        .iter()
        .map(|coordinate| format!("__{}={}", last_part(&coordinate.key), coordinate.value))
        .collect();
    let mut part: String = text.chars().map(safe).collect();
    if part.len() > LONGEST_FILE_PART {
        // FNV-1a: equal names are numbered, so that the hash need not be unique.
        let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        part.truncate(LONGEST_FILE_PART - 17);
        part += &format!("_{hash:016x}");
    }
    part
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

/// Derives coordinates from canonical manifests with the names of their models: the keys in which manifests of one model differ,
/// except the replicate and what is recorded. With several models, the model comes first.
pub(crate) fn of_manifests<'a>(manifests: &[(&'a str, &str)]) -> Vec<Vec<Coordinate>> {
    let models: BTreeSet<&str> = manifests.iter().map(|(model, _)| *model).collect();
    if models.len() < 2 {
        let texts: Vec<&str> = manifests.iter().map(|(_, text)| *text).collect();
        return of_one_model(&texts);
    }
    let of_model = |model: &str| {
        let texts = manifests.iter().filter(|(other, _)| *other == model).map(|(_, text)| *text);
        of_one_model(&texts.collect::<Vec<_>>()).into_iter()
    };
    let mut found: BTreeMap<&str, _> =
        models.iter().map(|model| (*model, of_model(model))).collect();
    let with_model = |(model, _): &(&'a str, &str)| {
        let own = Coordinate { key: "model".to_owned(), value: (*model).to_owned() };
        let others = found.get_mut(model).and_then(Iterator::next).unwrap_or_default();
        [own].into_iter().chain(others).collect()
    };
    manifests.iter().map(with_model).collect()
}

fn of_one_model(canonical: &[&str]) -> Vec<Vec<Coordinate>> {
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
        let coordinates = of_manifests(&texts.each_ref().map(|text| ("gas", text.as_str())));
        assert_eq!(text(&coordinates[0]), "temperature_k = 200");
        assert_eq!(text(&coordinates[1]), "temperature_k = 373.15");
        assert_eq!(coordinates[0], coordinates[2]);
        assert_eq!(coordinates[0][0].key, "model.gas.temperature_k");
    }

    #[test]
    fn vectors_are_shown_in_parentheses() {
        let at =
            |key: &str, value: &str| Coordinate { key: key.to_owned(), value: value.to_owned() };
        let gravity = at("model.dem.gravity_m_per_s2", "0_-9.81");
        assert_eq!(label(std::slice::from_ref(&gravity)), "gravity = (0, -9.81) m/s²");
        assert_eq!(text(&[gravity]), "gravity_m_per_s2 = (0, -9.81)");
        // Without the record of the experiment, it is written as in the manifest.
        assert_eq!(shown_value(&at("model.gas.center_m", "[3.0, 1.5]")), "(3, 1.5)");
        // Controls.
        assert_eq!(shown_value(&at("variant", "0_1")), "0_1");
        assert_eq!(shown_value(&at("model.dem.radius_m", "min_1_max_2")), "min_1_max_2");
        assert_eq!(shown_value(&at("model.dem.walls", "value-2")), "value-2");
    }

    #[test]
    fn runs_of_two_models_are_compared_within_each() {
        let gas = |radius: &str| format!("seed = 1\n[model.gas]\nradius_m = {radius}\n");
        let (one, other) = (gas("1.0"), gas("2.0"));
        let orbit = "seed = 1\n[model.orbit]\nduration_days = 3.0\n";
        let all = of_manifests(&[("gas", &one), ("orbit", orbit), ("gas", &other)]);
        let names: Vec<String> = all.iter().map(|coordinates| text(coordinates)).collect();
        let expected = ["model = gas, radius_m = 1", "model = orbit", "model = gas, radius_m = 2"];
        assert_eq!(names, expected);
    }

    #[test]
    fn name_of_a_file_is_short_enough_for_a_file_system() {
        let named = |name: &str| {
            file_part(&[Coordinate { key: "variant".to_owned(), value: name.to_owned() }])
        };
        let (long, other) = ("n".repeat(240), "n".repeat(241));
        assert_eq!(named(&long).len(), LONGEST_FILE_PART);
        assert_ne!(named(&long), named(&other));
        assert_eq!(named("Verlet \u{e4}"), "__variant=Verlet__");
        assert_eq!(named(&long[..100]), format!("__variant={}", &long[..100]));
    }

    #[test]
    fn values_are_numbers_where_they_are_written_as_numbers() {
        let value = |key: &str, value: &str| {
            value_of(&Coordinate { key: key.to_owned(), value: value.to_owned() })
        };
        let text = |text: &str| CoordinateValue::Text(text.to_owned());
        assert_eq!(value("model.gas.temperature_k", "300"), CoordinateValue::Integer(300));
        assert_eq!(value("model.gas.temperature_k", "-1.5e-3"), CoordinateValue::Number(-1.5e-3));
        assert_eq!(value("model.dem.gravity_m_per_s2", "0_-9.81"), text("0_-9.81"));
        // Control: a word that Rust reads as a number, and a variant's name, are texts.
        assert_eq!(value("model.gas.propagation", "infinity"), text("infinity"));
        assert_eq!(value("variant", "300"), text("300"));
    }

    #[test]
    fn axes_are_named_by_the_last_part_of_their_key_if_it_is_unique() {
        let at = |key: &str| Coordinate { key: key.to_owned(), value: "1".to_owned() };
        let all = [at("model.gas.radius_m"), at("model.gas.a.mean"), at("model.gas.b.mean")];
        let names = AxisNames::of([all.as_slice()]);
        assert_eq!(names.name("model.gas.radius_m"), "radius_m");
        assert_eq!(names.name("model.gas.b.mean"), "model.gas.b.mean");
    }
}
