//! Numbers as text, for terminals, plots and reports.

/// Relative differences below this are rounding errors.
const ROUNDING: f64 = 1e-9;

/// Formats a number with its standard error in the last digits, such as 1.3182(13)·10⁻¹⁸; with six digits if the error
/// is unknown.
pub(crate) fn with_error(value: f64, standard_error: Option<f64>) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    let error = standard_error.filter(|error| {
        error.is_finite() && *error > ROUNDING * value.abs() && *error > f64::MIN_POSITIVE
    });
    let Some(error) = error else { return six_digits(value) };
    let size = value.abs().max(error);
    let exponent = decimal_exponent(size);
    // Errors of more than two digits before the decimal point are written with a power of ten as well.
    let plain = (-2..=4).contains(&exponent) && decimal_exponent(error) < 2;
    let unit = if plain { 1.0 } else { 10.0_f64.powi(exponent) };
    let (value, error) = (value / unit, error / unit);
    // Two digits of the error, which is below 100.
    let decimals = (1 - decimal_exponent(error)).max(0);
    let digits = libm::round(error * 10.0_f64.powi(decimals));
    let text = format!("{value:.*}({digits})", decimals as usize);
    if plain { text } else { format!("{text}·{}", power_text(exponent)) }
}

/// A standard error below this fraction of the value is not shown in a sentence.
const SHOWN_ERROR: f64 = 1e-6;

/// Formats a number with its standard error as sentences contain it, with two digits of the error: 24.5 ± 2.2, or
/// (1.3182 ± 0.0013)·10⁻¹⁸; `None` if the error is not finite, or too small to be shown.
pub(crate) fn plus_minus(value: f64, standard_error: f64) -> Option<String> {
    plus_minus_to(None, value, standard_error)
}

/// The same with some significant digits of the value, of which the error has the last: 24 ± 2. `None` also if the error is less.
pub(crate) fn plus_minus_to(digits: Option<u8>, value: f64, standard_error: f64) -> Option<String> {
    let is_shown = standard_error.is_finite()
        && value.is_finite()
        && standard_error > SHOWN_ERROR * value.abs()
        && standard_error > f64::MIN_POSITIVE;
    if !is_shown {
        return None;
    }
    let exponent = decimal_exponent(value.abs().max(standard_error));
    // The power of ten of the last digit.
    let last = match digits.filter(|_| value != 0.0) {
        Some(digits) => decimal_exponent(value.abs()) + 1 - i32::from(digits),
        None => decimal_exponent(standard_error) - 1,
    };
    // A last digit before the decimal point is written with a power of ten as well.
    let is_plain = (-2..=5).contains(&exponent) && last <= 0;
    let unit = if is_plain { 1.0 } else { 10.0_f64.powi(exponent) };
    let (value, error) = (value / unit, standard_error / unit);
    let decimals = usize::try_from(if is_plain { -last } else { exponent - last }).unwrap_or(0);
    let rounded = format!("{error:.decimals$}");
    if rounded.chars().all(|digit| matches!(digit, '0' | '.')) {
        return None;
    }
    let text = format!("{value:.decimals$} ± {rounded}").replace('-', "−");
    Some(if is_plain { text } else { format!("({text})·{}", power_text(exponent)) })
}

/// Formats a number in units of a power of ten, with two digits of its standard error, or with some digits of the value if it has none;
/// `None` for a number that is not finite.
pub(crate) fn with_power(
    value: f64,
    standard_error: Option<f64>,
    power: i32,
    digits: u8,
) -> Option<String> {
    if !value.is_finite() || value == 0.0 {
        return None;
    }
    let unit = 10.0_f64.powi(power);
    let shown = standard_error.filter(|error| plus_minus(value, *error).is_some());
    let last = match shown {
        Some(error) => decimal_exponent(error) - 1,
        None => decimal_exponent(value.abs()) + 1 - i32::from(digits),
    };
    let decimals = usize::try_from(power - last).unwrap_or(0);
    let number = format!("{:.decimals$}", value / unit).replace('-', "−");
    let text = match shown {
        Some(error) => format!("({number} ± {:.decimals$})", error / unit),
        None => number,
    };
    Some(format!("{text}·{}", power_text(power)))
}

/// The power of ten of the first digit of a positive number.
pub(crate) fn power_of(value: f64) -> i32 {
    decimal_exponent(value)
}

/// Formats a number with some significant digits as sentences contain it, without zeros at the end of decimals.
pub(crate) fn significant(value: f64, digits: u8) -> String {
    trimmed(value, digits, trim_zeros)
}

/// The same with zeros at the end.
pub(crate) fn fixed(value: f64, digits: u8) -> String {
    trimmed(value, digits, str::to_owned)
}

fn trimmed(value: f64, digits: u8, trim: fn(&str) -> String) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.abs().to_string();
    }
    let rounded = format!("{value:.*e}", usize::from(digits.max(1)) - 1);
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    // A number with more digits than are significant has a power of ten from 100,000 on.
    let largest = if digits > 5 { 5 } else { 4 };
    let text = if (-3..=largest).contains(&exponent) {
        let decimals = usize::try_from(i32::from(digits) - 1 - exponent).unwrap_or(0);
        // Digits before the decimal point are rounded as well.
        let value: f64 = rounded.parse().unwrap_or(value);
        trim(&format!("{value:.decimals$}"))
    } else {
        format!("{}·{}", trim(mantissa), power_text(exponent))
    };
    text.replace('-', "−")
}

fn decimal_exponent(value: f64) -> i32 {
    libm::log10(value).floor() as i32
}

/// Formats a number with six digits.
pub(crate) fn six_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = decimal_exponent(value.abs());
    if (-3..=5).contains(&exponent) {
        let text = format!("{value:.*}", usize::try_from(5 - exponent).unwrap_or(0));
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        let unit = 10.0_f64.powi(exponent);
        let text = format!("{:.5}", value / unit);
        let mantissa = text.trim_end_matches('0').trim_end_matches('.');
        format!("{mantissa}·{}", power_text(exponent))
    }
}

/// Most digits of a number in a text that a sentence repeats.
const MOST_DIGITS: u8 = 6;

/// Rounds the numbers in a text that have more than six digits, except for whole ones, which count or identify.
pub(crate) fn with_short_numbers(text: &str) -> String {
    let (mut short, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(|character: char| character.is_ascii_digit()) {
        let (before, from) = rest.split_at(at);
        let (number, after) = from.split_at(number_length(from));
        let mantissa = number.split(['e', 'E']).next().unwrap_or(number);
        let digits = mantissa.chars().filter(char::is_ascii_digit).count();
        let is_whole = number.chars().all(|character| character.is_ascii_digit());
        let is_long = digits > usize::from(MOST_DIGITS) && !is_whole;
        let value: Option<f64> = number.parse().ok().filter(|value: &f64| value.is_finite());
        short.push_str(before);
        match value.filter(|_| is_long) {
            Some(value) => short.push_str(&significant(value, MOST_DIGITS)),
            None => short.push_str(number),
        }
        rest = after;
    }
    short + rest
}

/// Length of the number at the start of a text.
fn number_length(text: &str) -> usize {
    let digits =
        |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let mut length = digits(text);
    if let Some(decimals) = text[length..].strip_prefix('.').map(digits).filter(|count| *count > 0)
    {
        length += 1 + decimals;
    }
    let exponent = text[length..].strip_prefix(['e', 'E']).map(|exponent| {
        let sign = usize::from(exponent.starts_with(['+', '-']));
        (sign, digits(&exponent[sign..]))
    });
    match exponent {
        Some((sign, digits)) if digits > 0 => length + 1 + sign + digits,
        _ => length,
    }
}

/// Formats a number with two digits.
pub(crate) fn two_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let exponent = decimal_exponent(value.abs());
    let unit = 10.0_f64.powi(exponent - 1);
    // A power of ten below 1e-300 and its inverse are not both exact.
    six_digits(if exponent > -300 { libm::round(value / unit) * unit } else { value })
}

/// Formats a number in few characters, with a power of ten if it is very large or small.
pub(crate) fn short_number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = libm::log10(value.abs() * (1.0 + 1e-12)).floor() as i32;
    if (-2..=4).contains(&exponent) {
        let digits = format!("{value:.*}", usize::try_from(4 - exponent).unwrap_or(0));
        return trim_zeros(&digits).replace('-', "−");
    }
    let mantissa = trim_zeros(&format!("{:.3}", value / 10.0_f64.powi(exponent))).replace('-', "−");
    let power = power_text(exponent);
    if mantissa == "1" { power } else { format!("{mantissa}·{power}") }
}

/// Formats a number with three digits.
pub(crate) fn three_digits(value: f64) -> String {
    short_number(format!("{value:.2e}").parse().unwrap_or(value))
}

fn trim_zeros(digits: &str) -> String {
    if digits.contains('.') {
        digits.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        digits.to_owned()
    }
}

/// Formats a power of ten, such as 10⁻¹⁸.
pub(crate) fn power_text(exponent: i32) -> String {
    let digits: String = exponent
        .to_string()
        .chars()
        .map(|character| match character {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => {
                let offset = digit.to_digit(10).unwrap_or(0);
                char::from_u32(0x2070 + offset).unwrap_or(digit)
            }
        })
        .collect();
    format!("10{digits}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_sentences_have_two_digits_of_error_or_few_digits() {
        let shown = |value, error| plus_minus(value, error).unwrap_or_default();
        assert_eq!(shown(24.479, 2.1896), "24.5 ± 2.2");
        assert_eq!(shown(-0.43491, 0.00118), "−0.4349 ± 0.0012");
        assert_eq!(shown(1.318_24e-18, 1.3e-21), "(1.3182 ± 0.0013)·10⁻¹⁸");
        assert_eq!(shown(3.4e5, 18_439.0), "(3.40 ± 0.18)·10⁵");
        let rounded = |digits, value, error| plus_minus_to(Some(digits), value, error);
        assert_eq!(rounded(2, 24.479, 2.1896).as_deref(), Some("24 ± 2"));
        assert_eq!(rounded(6, 24.479, 2.1896).as_deref(), Some("24.4790 ± 2.1896"));
        assert_eq!(rounded(2, 12_345.0, 2_600.0).as_deref(), Some("(1.2 ± 0.3)·10⁴"));
        assert_eq!(rounded(3, 455.1, 0.003), None);
        // Too small to be shown, unknown, or not a number.
        assert_eq!([shown(300.0, 1e-12), shown(1.0, f64::NAN), shown(f64::NAN, 1.0)], ["", "", ""]);
        for (value, digits, text) in [
            (0.789_12, 3, "0.789"),
            (14_610.0, 6, "14610"),
            (12_319.4, 3, "12300"),
            (326_114.0, 3, "3.26·10⁵"),
            (-9.006e-5, 3, "−9.01·10⁻⁵"),
            (0.9999, 3, "1"),
            (0.0, 3, "0"),
            (-0.0, 3, "0"),
        ] {
            assert_eq!(significant(value, digits), text);
        }
    }

    /// Control: whole numbers, short ones and words are as they were.
    #[test]
    fn numbers_of_a_repeated_text_have_at_most_six_digits() {
        let text = "disc 1234567 at (0.123456789012, -4.5) m after 1.23456789e-5 s, key 45d74f2a, e = 0.5.";
        let short =
            "disc 1234567 at (0.123457, -4.5) m after 1.23457·10⁻⁵ s, key 45d74f2a, e = 0.5.";
        assert_eq!(with_short_numbers(text), short);
        assert_eq!(with_short_numbers(short), short);
    }

    #[test]
    fn numbers_carry_their_error_in_the_last_digits() {
        assert_eq!(with_error(1.318_24e-18, Some(1.3e-21)), "1.3182(13)·10⁻¹⁸");
        assert_eq!(with_error(-0.019_61, Some(0.000_73)), "-0.01961(73)");
        assert_eq!(with_error(912.3456, Some(0.123)), "912.35(12)");
        assert_eq!(with_error(12_345.0, Some(25.0)), "12345(25)");
        assert_eq!(with_error(47_400.0, Some(7218.0)), "4.74(72)·10⁴");
        assert_eq!(with_error(47.4, Some(7218.0)), "0.0(72)·10³");
        assert_eq!(with_error(0.000_4, Some(0.02)), "0.000(20)");
        assert_eq!(with_error(0.000_1, None), "10⁻⁴".replace("10⁻⁴", "1·10⁻⁴"));
        assert_eq!(with_error(0.5, None), "0.5");
        assert_eq!(with_error(f64::NAN, None), "NaN");
    }
}
