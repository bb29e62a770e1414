//! The horizontal axis of a plot over a swept key: numbers, or words in the order of the sweep.

use crate::input::coordinates::{self, CoordinateValue, last_part, value_of};
use kinetoscope_console::Message;
use kinetoscope_manifest::{Axis as SweptAxis, Coordinate, nearest};

/// The full name of the swept key that is the horizontal axis: the requested one, or the only numeric one, or the only one.
///
/// # Errors
/// A key that is not swept, or a choice among several, with the keys.
pub(crate) fn swept_key(
    requested: Option<&str>,
    places: &[Vec<Coordinate>],
    axes: &[SweptAxis],
) -> Result<String, Message> {
    let keys = coordinates::keys_of(places.iter().map(Vec::as_slice));
    let listed =
        |keys: &[&str]| keys.iter().map(|key| last_part(key)).collect::<Vec<_>>().join(", ");
    let all: Vec<&str> = keys.iter().map(String::as_str).collect();
    let Some(x) = requested else {
        let numeric: Vec<&str> =
            keys.iter().filter(|key| has_numbers(key, places)).map(String::as_str).collect();
        // Without numbers, words are the axis.
        let (kind, eligible) = if numeric.is_empty() { ("", all) } else { ("numeric ", numeric) };
        let axis_of = |key: &str| axes.iter().position(|axis| axis.keys.iter().any(|it| it == key));
        return match eligible.as_slice() {
            [] => Err(Message::new(
                "a plot of a metric needs recordings of a sweep",
                "name a field of a channel, such as `/energy.kinetic_j`, which is plotted over time",
            )),
            [first, rest @ ..]
                if rest
                    .iter()
                    .all(|key| axis_of(key).is_some() && axis_of(key) == axis_of(first)) =>
            {
                Ok((*first).to_owned())
            }
            _ => Err(Message::new(
                format!("the recordings differ in {} {kind}keys", eligible.len()),
                format!("name the horizontal axis, one of: {}", listed(&eligible)),
            )),
        };
    };
    let Some(key) = keys.iter().find(|key| *key == x || last_part(key) == x) else {
        let names = all.iter().map(|key| last_part(key));
        let help = match nearest(last_part(x), names) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if all.is_empty() => "the recordings differ in no key".to_owned(),
            None => format!("name one of: {}", listed(&all)),
        };
        return Err(Message::new(format!("`{x}` is not swept"), help));
    };
    Ok(key.clone())
}

/// Whether each value of a swept key is a number.
fn has_numbers(key: &str, places: &[Vec<Coordinate>]) -> bool {
    let of_key = |coordinate: &&Coordinate| coordinate.key == key;
    let mut values = places.iter().flatten().filter(of_key).map(value_of);
    values.all(|value| !matches!(value, CoordinateValue::Text(_)))
}

/// The words of a swept key in the order of the sweep; empty for a key with numbers.
pub(super) fn words(key: &str, places: &[Vec<Coordinate>]) -> Vec<String> {
    if has_numbers(key, places) {
        return Vec::new();
    }
    let mut words = Vec::new();
    for coordinate in places.iter().flatten().filter(|coordinate| coordinate.key == key) {
        let word = coordinates::word(coordinate);
        if !words.contains(&word) {
            words.push(word);
        }
    }
    words
}

/// The place on the horizontal axis: the number of the key, or that of its word.
pub(super) fn position(place: &[Coordinate], key: &str, words: &[String]) -> Option<f64> {
    if words.is_empty() {
        return number(place, key);
    }
    let coordinate = place.iter().find(|coordinate| coordinate.key == key)?;
    let word = coordinates::word(coordinate);
    words.iter().position(|other| *other == word).map(|index| index as f64)
}

fn number(coordinates: &[Coordinate], key: &str) -> Option<f64> {
    match value_of(coordinates.iter().find(|coordinate| coordinate.key == key)?) {
        CoordinateValue::Integer(number) => Some(number as f64),
        CoordinateValue::Number(number) => Some(number),
        CoordinateValue::Text(_) => None,
    }
}
