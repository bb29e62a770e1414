//! Measured numbers as a reader writes them.

use crate::metric::{Deviation, Metric};
use crate::number_text::{
    fixed, plus_minus, plus_minus_to, power_of, power_text, significant, with_power,
};
use kinetoscope_manifest::{Bound, Check};

/// A measured number of an answer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AnswerNumber {
    /// The metric's name, which the sentence does not contain.
    pub(crate) metric: &'static str,
    /// The value with its standard error and its unit, such as "24.5 ± 2.2 degrees".
    pub(crate) text: String,
    /// Whether its checks pass; `None` without a check.
    pub(crate) is_passed: Option<bool>,
    /// Whether its checks compare it with a value, or the sentence states their bounds.
    pub(crate) is_compared: bool,
    /// Whether the sentence itself states that a check fails.
    pub(crate) is_failure_stated: bool,
    /// The tolerance of a check that passes in spite of a deviation of many standard errors, such as "within 5 % of theory".
    pub(crate) tolerance: Option<String>,
}

impl AnswerNumber {
    /// What the number is marked with: whether its checks pass, unless the sentence states that they fail, or does not state what they require: a mark would
    /// be read as agreement.
    pub(crate) fn mark(&self) -> Option<bool> {
        let is_shown =
            |passed: &bool| if *passed { self.is_compared } else { !self.is_failure_stated };
        self.is_passed.filter(is_shown)
    }
}

/// Standard errors above which a deviation is not explained by scatter, so that a passed check needs its tolerance in words.
const LARGEST_SCATTER: f64 = 3.0;

/// The tolerance of a check that a metric passes although it deviates by many standard errors; `None` for other checks.
pub(super) fn stated_tolerance(check: &Check, metric: &Metric) -> Option<String> {
    let (expected, tolerance) = match check.bound {
        Bound::Near { expected, tolerance } => (expected, in_unit(tolerance, metric)),
        Bound::NearRelative { expected, relative_tolerance } => {
            (expected, percent(relative_tolerance))
        }
        _ => return None,
    };
    let of = expected.map_or_else(|| "theory".to_owned(), |expected| in_unit(expected, metric));
    let expected = expected.or(metric.theory_value())?;
    let error = metric.standard_error().filter(|error| *error > 0.0)?;
    let is_beyond = (metric.value() - expected).abs() > LARGEST_SCATTER * error;
    is_beyond.then(|| format!("within {tolerance} of {of}"))
}

/// The fraction above which a violated quantity is not called conserved.
const LARGEST_VIOLATION: f64 = 0.1;

/// The quantity that is conserved, unless its violation is exactly 0, or large.
pub(super) fn conserved(metric: &Metric) -> Option<&'static str> {
    let law = metric.theory.filter(|theory| theory.in_range())?.law?;
    let size = metric.value().abs();
    law.conserved.filter(|_| size > 0.0 && size <= LARGEST_VIOLATION)
}

pub(super) fn size_text(metric: &Metric) -> String {
    format!("{}{}", significant(metric.value().abs(), 2), unit_words(metric.unit()))
}

/// A number of a sentence with its text.
pub(super) fn number_with(metric: &Metric, text: String, is_passed: Option<bool>) -> AnswerNumber {
    let (is_compared, is_failure_stated, tolerance) = (true, false, None);
    let metric = metric.name();
    AnswerNumber { metric, text, is_passed, is_compared, is_failure_stated, tolerance }
}

/// The form of a number.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NumberForm {
    /// Whether the number is shown without its sign.
    pub(super) is_size: bool,
    /// Whether a fraction is shown in percent.
    pub(super) is_in_percent: bool,
    /// Number of significant digits; `None` for two of the standard error, or three.
    pub(super) digits: Option<u8>,
    /// Whether the words after the number name its unit.
    pub(super) is_without_unit: bool,
}

/// Significant digits of a value without a standard error.
const DIGITS: u8 = 3;
/// Maximum number of digits of a theoretical value.
const MOST_DIGITS: i32 = 12;

/// A relative change and a fraction are in percent.
pub(super) fn form_of(metric: &Metric) -> NumberForm {
    let label = metric.definition.label;
    let is_in_percent = ["relative ", "fraction "].iter().any(|word| label.starts_with(word));
    NumberForm { is_in_percent, ..NumberForm::default() }
}

/// The form of a value whose difference from theory is stated without a standard error: with the digits of which two are of the
/// difference, so that it follows from the numbers that are shown.
pub(super) fn compared_form(metric: &Metric) -> NumberForm {
    NumberForm { digits: difference_digits(metric), ..form_of(metric) }
}

/// Relative differences from theory above which more digits are shown.
pub(super) const SAME: f64 = 5e-4;
/// Maximum number of digits for the sake of a difference.
const MOST_COMPARED_DIGITS: i32 = 6;

fn difference_digits(metric: &Metric) -> Option<u8> {
    let is_bare = matches!(metric.deviation(), Some(Deviation::Bare(_) | Deviation::Bound { .. }));
    let theory = metric.theory_value().filter(|theory| is_bare && *theory != 0.0)?;
    let is_shown = |error| plus_minus(metric.value(), error).is_some();
    if metric.standard_error().is_some_and(is_shown) || metric.value() == 0.0 {
        return None;
    }
    let difference = (metric.value() - theory).abs();
    if difference < SAME * theory.abs() || difference > theory.abs() {
        return None;
    }
    let digits = power_of(metric.value().abs()) - power_of(difference) + 2;
    u8::try_from(digits.clamp(i32::from(DIGITS), MOST_COMPARED_DIGITS)).ok()
}

/// A value as its digits in a comparison state it.
pub(super) fn shown_value(value: f64, metric: &Metric) -> f64 {
    let shown = difference_digits(metric)
        .and_then(|digits| format!("{value:.*e}", usize::from(digits) - 1).parse().ok());
    shown.unwrap_or(value)
}

/// The values of several points with one power of ten, if they are close, and with the same number of digits.
pub(super) fn common_texts(metrics: &[&Metric]) -> Vec<String> {
    let plain: Vec<String> =
        metrics.iter().map(|metric| metric_text(metric, form_of(metric))).collect();
    let powers = metrics.iter().filter(|metric| metric.value() != 0.0);
    let powers: Vec<i32> = powers.map(|metric| power_of(metric.value().abs())).collect();
    let (Some(least), Some(greatest)) = (powers.iter().min(), powers.iter().max()) else {
        return plain;
    };
    let has_powers = |text: &String| text.contains("·10");
    let texts = metrics.iter().zip(&plain);
    if plain.iter().any(has_powers) {
        let is_close = greatest - least <= 1 && !metrics.iter().any(|it| form_of(it).is_in_percent);
        let common = |(metric, plain): (&&Metric, &String)| {
            let text = with_power(metric.value(), metric.standard_error(), *greatest, DIGITS);
            text.filter(|_| is_close)
                .map_or_else(|| plain.clone(), |text| text + &unit_words(metric.unit()))
        };
        return texts.map(common).collect();
    }
    let digits = plain.iter().map(|text| shown_digits(text)).max().unwrap_or(DIGITS);
    let is_whole = plain.iter().all(|text| !text.contains('.'));
    let same_digits = |(metric, plain): (&&Metric, &String)| {
        let form = form_of(metric);
        let is_plain = is_whole || plain.contains('±') || digits > DIGITS || metric.value() == 0.0;
        if is_plain {
            return plain.clone();
        }
        let is_in_percent = form.is_in_percent && matches!(metric.unit(), "" | "1");
        let factor = if is_in_percent { 100.0 } else { 1.0 };
        let unit = if is_in_percent { " %".to_owned() } else { unit_words(metric.unit()) };
        fixed(factor * metric.value(), digits) + &unit
    };
    texts.map(same_digits).collect()
}

/// Number of significant digits of the number at the start of a text.
fn shown_digits(text: &str) -> u8 {
    let number = text.split(' ').next().unwrap_or_default();
    let digits = number.chars().filter(char::is_ascii_digit);
    u8::try_from(digits.skip_while(|digit| *digit == '0').count()).unwrap_or(u8::MAX)
}

/// The value of a metric with its standard error and its unit.
pub(super) fn metric_text(metric: &Metric, form: NumberForm) -> String {
    if is_rounding(metric) {
        return format!("{} up to rounding", text_of(0.0, None, metric.unit(), form));
    }
    text_of(metric.value(), metric.standard_error(), metric.unit(), form)
}

/// An angle below this, in degrees, is a rounding error of the positions.
const LARGEST_ROUNDING_DEGREES: f64 = 1e-9;

/// Whether a value with a unit, such as an angle, is a rounding error where it should be 0.
pub(super) fn is_rounding(metric: &Metric) -> bool {
    let is_of_law = metric.theory_value() == Some(0.0)
        && metric.deviation() == Some(Deviation::Rounding)
        && !metric.is_of_conservation_law();
    let is_angle = metric.unit() == "degrees" && metric.value().abs() < LARGEST_ROUNDING_DEGREES;
    metric.value() != 0.0 && !["", "1"].contains(&metric.unit()) && (is_of_law || is_angle)
}

/// A number with its standard error and its unit.
pub(super) fn text_of(
    value: f64,
    standard_error: Option<f64>,
    unit: &str,
    form: NumberForm,
) -> String {
    let is_in_percent = form.is_in_percent && matches!(unit, "" | "1");
    let factor = if is_in_percent { 100.0 } else { 1.0 };
    let unit = if is_in_percent { " %".to_owned() } else { unit_words(unit) };
    let unit = if form.is_without_unit { "" } else { &unit };
    let value = factor * if form.is_size { value.abs() } else { value };
    let error = standard_error.map(|error| factor * error);
    match error.and_then(|error| plus_minus_to(form.digits, value, error)) {
        // A percent sign or a unit belongs to both numbers.
        Some(text) if is_in_percent && !unit.is_empty() => format!("({text}){unit}"),
        Some(text) => format!("{text}{unit}"),
        None => format!("{}{unit}", value_text(value, form.digits)),
    }
}

/// A value without an error: all digits of a count, else the given number of digits or three, and those before the decimal point.
fn value_text(value: f64, digits: Option<u8>) -> String {
    let is_count = value == libm::round(value) && value.abs() < 1e6;
    let is_long = (1e3..1e4).contains(&value.abs());
    let default = if is_count { 6 } else { DIGITS + u8::from(is_long) };
    significant(value, digits.unwrap_or(default))
}

/// A bare value in the metric's unit.
pub(super) fn in_unit(value: f64, metric: &Metric) -> String {
    text_of(value, None, metric.unit(), form_of(metric))
}

/// A theoretical value in the metric's unit, with the digits that the metric's standard error has.
pub(super) fn theory_text(theory: f64, metric: &Metric) -> String {
    let of_difference = difference_digits(metric).filter(|_| metric.theory_value() == Some(theory));
    let digits = of_difference.or_else(|| theory_digits(theory, metric));
    let form = NumberForm { digits, ..form_of(metric) };
    let measured = metric_text(metric, compared_form(metric));
    // Next to (5.56 ± 0.24)·10³, theory is 5.58·10³, not 5580.
    let power = if theory == 0.0 { 0 } else { power_of(theory.abs()) };
    let has_power = measured.contains(&format!("·{}", power_text(power)));
    let text = with_power(theory, None, power, form.digits.unwrap_or(DIGITS));
    match text.filter(|_| has_power && !form.is_in_percent) {
        Some(text) => text + &unit_words(metric.unit()),
        None => text_of(theory, None, metric.unit(), form),
    }
}

/// The digits of a theoretical value down to the last one of the metric's standard error, at least three: rounded to fewer, it may lie on
/// the other side of the measured value. `None` without an error that is shown: the value has three digits, and so has theory.
pub(super) fn theory_digits(theory: f64, metric: &Metric) -> Option<u8> {
    let exponent = |value: f64| libm::log10(value.abs()).floor() as i32;
    let error = metric.standard_error().filter(|_| theory != 0.0)?;
    plus_minus(metric.value(), error)?;
    let digits = exponent(theory) - exponent(error) + 2;
    u8::try_from(digits.clamp(i32::from(DIGITS), MOST_DIGITS)).ok()
}

/// A fraction in percent, with two digits.
pub(super) fn percent(fraction: f64) -> String {
    format!("{} %", significant(100.0 * fraction, 2))
}

/// The unit after a number in a sentence; empty for a pure number.
pub(super) fn unit_words(unit: &str) -> String {
    match unit {
        "" | "1" => String::new(),
        "d" => " days".to_owned(),
        "1/s" => " per second".to_owned(),
        unit => format!(" {}", unit.replace("^2", "²")),
    }
}

/// Standard errors within which a value agrees with theory.
pub(super) const AGREES: f64 = 1.0;

/// A deviation in standard errors as a sentence states it. That of few replicates is the one of a normal distribution that is as likely,
/// and less than the quotient; but a value whose error bar does not reach theory is not called within its standard error.
pub(super) fn literal_errors(sigma: f64, metric: &Metric) -> f64 {
    if sigma.abs() > AGREES {
        return sigma;
    }
    let errors =
        metric.standard_error().into_iter().chain(metric.estimate.conditional_standard_error);
    let quotient = errors
        .reduce(f64::min)
        .zip(metric.theory)
        .map(|(error, theory)| ((metric.value() - theory.value) / error).abs());
    quotient.filter(|it| it.is_finite() && *it > AGREES).map_or(sigma, |it| it.copysign(sigma))
}
