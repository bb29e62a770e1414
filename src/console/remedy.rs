//! Errors whose text ends with the remedy: the last sentence or, in a single sentence, the last clause.
//!
//! A failed run is stored in its recording with this text; therefore, it is divided only when it is printed.

/// Puts the remedy of an error on a line of its own: `what\nhelp: remedy`.
#[must_use]
pub fn with_help(error: &str) -> String {
    if let Some((what, help)) = error.split_once("\nhelp: ") {
        let [what, help] = [what, help].map(|text| text.trim_end().trim_end_matches('.'));
        return format!("{what}\nhelp: {}", uncapitalized(help));
    }
    let text = error.trim_end().trim_end_matches('.');
    let clause = || ["; ", ": "].iter().filter_map(|end| text.rfind(end)).max();
    match text.rfind(". ").or_else(clause) {
        Some(end) => format!("{}\nhelp: {}", &text[..end], uncapitalized(&text[end + 2..])),
        None => text.to_owned(),
    }
}

/// The text with a small first letter, unless its first word is a symbol or an abbreviation.
#[must_use]
pub fn uncapitalized(text: &str) -> String {
    let mut letters = text.chars();
    match (letters.next(), letters.next()) {
        (Some(first), Some(second)) if second.is_lowercase() || text.starts_with("A ") => {
            first.to_lowercase().chain([second]).chain(letters).collect()
        }
        _ => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::with_help;

    #[test]
    fn remedy_is_the_last_sentence_or_clause() {
        for (error, expected) in [
            ("it fails at 1.5 m. Take a: b; or c.", "it fails at 1.5 m\nhelp: take a: b; or c"),
            ("it fails: badly; use another", "it fails: badly\nhelp: use another"),
            ("discs = 2, but one is given: add one", "discs = 2, but one is given\nhelp: add one"),
            ("it fails. MCAP files only", "it fails\nhelp: MCAP files only"),
            ("it fails. Why.\nhelp: A. B.", "it fails. Why\nhelp: A. B"),
            ("it fails\nhelp: The nearest. B.", "it fails\nhelp: the nearest. B"),
            ("it fails", "it fails"),
        ] {
            assert_eq!(with_help(error), expected);
        }
    }
}
