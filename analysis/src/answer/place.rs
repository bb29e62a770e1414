//! The points of a sweep and their keys in words.

use super::number::unit_words;
use crate::input::coordinates::{VARIANT, last_part, shown_value};
use crate::number_text::with_short_numbers;
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::{Coordinate, unit_of_key};

/// The point of a sweep in words, such as " at a friction of 0.5"; empty for a single run.
pub(super) fn place_words(coordinates: &[Coordinate]) -> String {
    let words = coordinates.iter().map(|coordinate| {
        let value = one_line(&shown_value(coordinate)).into_owned();
        if coordinate.key == VARIANT {
            return format!(" ({value})");
        }
        let value = with_short_numbers(&value);
        let unit = unit_of_key(&coordinate.key);
        let words = key_words(&coordinate.key, unit);
        // A number of things.
        if unit == "1" && words.ends_with('s') {
            return format!(" with {value} {words}");
        }
        let unit = unit_words(unit);
        // "1 day" is singular.
        let unit =
            unit.strip_suffix('s').filter(|it| value == "1" && *it == " day").unwrap_or(&unit);
        format!(" at {words} {value}{unit}")
    });
    words.collect()
}

/// The name of a key without its unit, with spaces.
pub(super) fn key_words(key: &str, unit: &str) -> String {
    let name = last_part(key);
    let suffix = format!(
        "_{}",
        unit.to_lowercase().replace('/', "_per_").replace('^', "").replace(' ', "_")
    );
    let name = name.strip_suffix(&suffix).unwrap_or(name);
    let name = if unit == "d" { name.strip_suffix("_days").unwrap_or(name) } else { name };
    name.replace('_', " ")
}
