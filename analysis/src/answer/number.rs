//! Measured numbers as a reader writes them.

use crate::metric::Metric;
use crate::number_text::{plus_minus, plus_minus_to, significant};

/// A measured number of an answer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AnswerNumber {
    /// The metric's name, which the sentence does not contain.
    pub(crate) metric: &'static str,
    /// The value with its standard error and its unit, such as "24.5 ± 2.2 degrees".
    pub(crate) text: String,
    /// Whether its checks pass; `None` without a check.
    pub(crate) is_passed: Option<bool>,
    /// Whether the sentence itself states that a check fails.
    pub(crate) is_failure_stated: bool,
}

impl AnswerNumber {
    /// What the number is marked with: whether its checks pass, unless the sentence states it.
    pub(crate) fn mark(&self) -> Option<bool> {
        self.is_passed.filter(|is_passed| *is_passed || !self.is_failure_stated)
    }
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

/// The value of a metric with its standard error and its unit.
pub(super) fn metric_text(metric: &Metric, form: NumberForm) -> String {
    text_of(metric.value(), metric.standard_error(), metric.unit(), form)
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

/// A value without an error: all digits of a count, else the given number of digits or three.
fn value_text(value: f64, digits: Option<u8>) -> String {
    let is_count = value == libm::round(value) && value.abs() < 1e6;
    significant(value, digits.unwrap_or(if is_count { 6 } else { DIGITS }))
}

/// A bare value in the metric's unit.
pub(super) fn in_unit(value: f64, metric: &Metric) -> String {
    text_of(value, None, metric.unit(), form_of(metric))
}

/// A theoretical value in the metric's unit, with the digits that the metric's standard error has.
pub(super) fn theory_text(theory: f64, metric: &Metric) -> String {
    let form = NumberForm { digits: theory_digits(theory, metric), ..form_of(metric) };
    text_of(theory, None, metric.unit(), form)
}

/// The digits of a theoretical value down to the last one of the metric's standard error, at least three: rounded to fewer, it may lie on
/// the other side of the measured value. `None` without an error that is shown.
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
