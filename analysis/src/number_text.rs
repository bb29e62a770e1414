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
    let is_shown = standard_error.is_finite()
        && value.is_finite()
        && standard_error > SHOWN_ERROR * value.abs()
        && standard_error > f64::MIN_POSITIVE;
    if !is_shown {
        return None;
    }
    let exponent = decimal_exponent(value.abs().max(standard_error));
    // Errors of more than two digits before the decimal point are written with a power of ten as well.
    let is_plain = (-2..=5).contains(&exponent) && decimal_exponent(standard_error) < 2;
    let unit = if is_plain { 1.0 } else { 10.0_f64.powi(exponent) };
    let (value, error) = (value / unit, standard_error / unit);
    let decimals = usize::try_from(1 - decimal_exponent(error)).unwrap_or(0);
    let text = format!("{value:.decimals$} ± {error:.decimals$}").replace('-', "−");
    Some(if is_plain { text } else { format!("({text})·{}", power_text(exponent)) })
}

/// Formats a number with some significant digits as sentences contain it, without zeros at the end of decimals.
pub(crate) fn significant(value: f64, digits: u8) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.abs().to_string();
    }
    let rounded = format!("{value:.*e}", usize::from(digits.max(1)) - 1);
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let text = if (-3..=5).contains(&exponent) {
        let decimals = usize::try_from(i32::from(digits) - 1 - exponent).unwrap_or(0);
        // Digits before the decimal point are rounded as well.
        let value: f64 = rounded.parse().unwrap_or(value);
        trim_zeros(&format!("{value:.decimals$}"))
    } else {
        format!("{}·{}", trim_zeros(mantissa), power_text(exponent))
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
