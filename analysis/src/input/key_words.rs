//! Names of manifest keys and of fields for a reader: words, with the unit that the last part of the name contains.

/// The quantity and the unit of a manifest key or a field of a channel.
pub(crate) fn words_and_unit(key: &str) -> (String, &'static str) {
    const UNITS: &[(&str, &str)] = &[
        ("_n_s_per_m", "N s/m"),
        ("_m2_per_s2", "m²/s²"),
        ("_au2_per_day2", "AU²/day²"),
        ("_au2_per_day", "AU²/day"),
        ("_au_per_day", "AU/day"),
        ("_percent", "%"),
        ("_ppm", "ppm"),
        ("_j_s", "J s"),
        ("_n_s", "N s"),
        ("_rad", "rad"),
        ("_uj", "µJ"),
        ("_j", "J"),
        ("_n_per_m", "N/m"),
        ("_m_per_s2", "m/s²"),
        ("_m_per_s", "m/s"),
        ("_rad2", "rad²"),
        ("_kg", "kg"),
        ("_days", "days"),
        ("_au", "AU"),
        ("_k", "K"),
        ("_m", "m"),
        ("_s", "s"),
    ];
    let found = UNITS.iter().find_map(|(ending, unit)| Some((key.strip_suffix(ending)?, *unit)));
    let (words, unit) = found.unwrap_or((key, ""));
    (words.replace('_', " "), unit)
}

#[cfg(test)]
mod tests {
    use super::words_and_unit;

    #[test]
    fn unit_is_not_part_of_the_words() {
        let expected = [
            ("time_step_days", "time step", "days"),
            ("temperature_k", "temperature", "K"),
            ("gravity_m_per_s2", "gravity", "m/s²"),
            ("steps_per_wall_contact", "steps per wall contact", ""),
        ];
        for (key, words, unit) in expected {
            assert_eq!(words_and_unit(key), (words.to_owned(), unit));
        }
    }
}
