//! Names, numbers and laws as text of a page.

use crate::metric::Law;
use maud::{Markup, html};

/// Numbers with minus signs in place of the hyphens that terminals and files contain, so that no line ends within a number; hyphens
/// within words stay.
pub(super) fn typographic(text: &str) -> String {
    let mut signed = String::with_capacity(text.len());
    let mut before = [' '; 2];
    for character in text.chars() {
        let is_exponent = before[0].is_ascii_digit() && before[1] == 'e';
        let is_sign = is_exponent || !before[1].is_alphanumeric();
        signed.push(if character == '-' && is_sign { '−' } else { character });
        before = [before[1], character];
    }
    signed
}

/// A law with its source, range and accuracy.
pub(super) fn law_text(law: &Law) -> String {
    let range =
        if law.range.is_empty() { String::new() } else { format!("; range: {}", law.range) };
    let accuracy = match law.relative_accuracy {
        0.0 => String::new(),
        accuracy => format!("; accuracy: {accuracy} of the value"),
    };
    format!("{law}{range}{accuracy}")
}

/// Text that may break after its dots and underscores, so that long names fit a phone; numbers stay whole.
pub(super) fn breakable(text: &str) -> Markup {
    let mut parts: Vec<(&str, bool)> = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(['_', '.']) {
        let (part, after) = rest.split_at(at + 1);
        let is_decimal_point =
            part.ends_with('.') && after.starts_with(|next: char| next.is_ascii_digit());
        parts.push((part, !is_decimal_point));
        rest = after;
    }
    html! {
        @for (part, can_break) in parts { (part) @if can_break { wbr; } }
        (rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hyphens_of_words_are_no_minus_signs() {
        assert_eq!(typographic("-1.5e-3 to -2"), "−1.5e−3 to −2");
        for text in ["within round-off", "the time-step", "run__1c-2.mcap", "2026-11-24"] {
            assert_eq!(typographic(text), text);
        }
    }

    #[test]
    fn names_break_and_numbers_do_not() {
        let metric = "pressure.measured at temperature_k = 373.15 <";
        let broken = "pressure.<wbr>measured at temperature_<wbr>k = 373.15 &lt;";
        assert_eq!(breakable(metric).into_string(), broken);
    }
}
