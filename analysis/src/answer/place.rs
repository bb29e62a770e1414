//! The points of a sweep and their keys in words.

use super::number::unit_words;
use crate::input::coordinates::{VARIANT, last_part, shown_value};
use crate::number_text::{significant, with_short_numbers};
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::{Coordinate, unit_of_key};

/// Digits of a setting with a power of ten.
const MOST_DIGITS: u8 = 6;

/// The point of a sweep in words, such as " at a friction of 0.5" or " (integrator rk4)"; empty for a single run.
pub(super) fn place_words(coordinates: &[Coordinate]) -> String {
    let words = coordinates.iter().map(|coordinate| {
        let value = one_line(&shown_value(coordinate)).into_owned();
        if coordinate.key == VARIANT {
            return format!(" ({value})");
        }
        let value = with_short_numbers(&value);
        let power = value.parse().ok().filter(|_| value.contains('e'));
        let value = power.map_or(value, |number| significant(number, MOST_DIGITS));
        let unit = unit_of_key(&coordinate.key);
        let words = key_words(&coordinate.key, unit);
        if is_number_of_things(&words, unit) {
            let words = words.strip_suffix('s').filter(|_| value == "1").unwrap_or(&words);
            return format!(" with {value} {words}");
        }
        let unit = unit_words(unit);
        // "1 day" is singular.
        let unit =
            unit.strip_suffix('s').filter(|it| value == "1" && *it == " day").unwrap_or(&unit);
        // "200 K" is a value, "rk4" is a choice.
        if shown_value(coordinate).parse::<f64>().is_err() {
            return format!(" ({words} {value})");
        }
        let article = if words.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
        format!(" at {article} {words} of {value}{unit}")
    });
    words.collect()
}

/// Whether a key is a number of things, such as discs: a plural without a unit. A radius is none.
pub(super) fn is_number_of_things(words: &str, unit: &str) -> bool {
    unit == "1" && words.ends_with('s') && !["radius", "mass"].contains(&words)
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

#[cfg(test)]
mod tests {
    use super::place_words;
    use kinetoscope_manifest::Coordinate;

    /// Guarantee: a number has its quantity and its unit, a choice its key.
    #[test]
    fn points_of_a_sweep_are_words() {
        let words = |key: &str, value: &str| {
            let [key, value] = [key, value].map(str::to_owned);
            place_words(&[Coordinate { key, value }])
        };
        assert_eq!(words("model.dem.friction", "0.5"), " at a friction of 0.5");
        assert_eq!(words("model.gas.orifice_width_m", "0.2"), " at an orifice width of 0.2 m");
        assert_eq!(words("model.orbit.time_step_days", "1"), " at a time step of 1 day");
        assert_eq!(words("model.orbit.integrator", "rk4"), " (integrator rk4)");
        assert_eq!(words("model.dem.discs", "20"), " with 20 discs");
        assert_eq!(words("model.dem.discs", "1"), " with 1 disc");
        assert_eq!(words("model.packing.radius", "0.2"), " at a radius of 0.2");
        assert_eq!(words("model.gas.mass_kg", "1e-26"), " at a mass of 1·10⁻²⁶ kg");
        assert_eq!(words("variant", "slow"), " (slow)");
    }
}
