//! How a number relates to theory, or to what a check expects, in words.

use super::number::{
    AGREES, SAME, compared_form, in_unit, is_rounding, literal_errors, metric_text, percent,
    shown_value, theory_text, unit_words,
};
use super::points::chance_words;
use crate::metric::{Deviation, Metric};
use crate::number_text::significant;
use kinetoscope_manifest::{Bound, Check};

/// Standard errors of a single value above which it is called unlikely.
const UNLIKELY: f64 = 3.0;
/// A relative tolerance below which a check requires the same number.
const SAME_NUMBER: f64 = 1e-9;
/// A ratio to theory above this is given as a factor, not in percent.
const LARGEST_EXCESS: f64 = 10.0;

/// The relation of a passed metric to what its check compares it with, as the end of a sentence: ", 2.1 standard errors above the
/// theoretical 0.5". A theoretical value is stated in place of bounds around it.
pub(super) fn relation(check: &Check, metric: &Metric) -> String {
    match check.bound {
        Bound::Near { expected: Some(expected), .. }
        | Bound::NearRelative { expected: Some(expected), .. } => to_expected(metric, expected),
        Bound::WithinStandardErrors { expected: Some(expected), .. } => {
            let value = format!("the expected {}", theory_text(expected, metric));
            metric.deviation_from(expected).map_or_else(String::new, |deviation| {
                let text = of_deviation(deviation, metric.value(), expected, 0.0, &value);
                text + &chance(deviation, metric)
            })
        }
        Bound::Range { minimum, maximum } if is_compared_with_range(metric) => {
            in_range(minimum, maximum, metric)
        }
        _ => to_theory(metric),
    }
}

/// Whether a check compares a metric with a value, expected or of theory.
pub(super) fn states_value(check: &Check) -> bool {
    !matches!(check.bound, Bound::Range { .. })
}

/// Whether the relation of a metric to its check states what this requires.
pub(super) fn states_requirement(check: &Check, metric: &Metric) -> bool {
    states_value(check) || is_compared_with_range(metric)
}

/// Whether the bounds of a check are stated: of a metric without a theoretical value, and of a conservation law, whose violation is
/// never 0.
fn is_compared_with_range(metric: &Metric) -> bool {
    metric.theory.is_none_or(|theory| theory.in_range() && metric.is_of_conservation_law())
}

/// The relation of a metric to its theoretical value; empty without one.
pub(super) fn to_theory(metric: &Metric) -> String {
    // The number itself says so.
    let Some(theory) = metric.theory.filter(|_| !is_rounding(metric)) else { return String::new() };
    let number = theory_text(theory.value, metric);
    let name = theory.law.and_then(|law| law.name);
    if let Some(violation) = theory.violation {
        return match name {
            Some(name) => {
                format!(", where {name} would give {number}, but does not apply: {violation}")
            }
            None => format!(", outside the range of its law: {violation}"),
        };
    }
    let value = match name {
        Some(name) => format!("the {number} of {name}"),
        None => format!("the theoretical {number}"),
    };
    let Some(deviation) = metric.deviation() else { return String::new() };
    match (deviation, metric.estimate.conditional_standard_error) {
        (Deviation::StandardErrors(sigma), Some(_)) => {
            conditional(sigma, metric.value(), theory.value, &value) + &chance(deviation, metric)
        }
        (Deviation::Rounding, _)
            if name.is_some_and(|it| metric.definition.label.ends_with(it)) =>
        {
            match ((metric.value() - theory.value) / theory.value).abs() {
                0.0 => ", exactly as the law requires".to_owned(),
                error => format!(", as the law requires, up to {}", significant(error, 1)),
            }
        }
        (Deviation::Bare(_) | Deviation::Bound { .. }, _)
            if metric_text(metric, compared_form(metric)) == number =>
        {
            match name {
                Some(name) => format!(", as {name} predicts"),
                None => ", as theory predicts".to_owned(),
            }
        }
        // A difference within the standard error is due to chance, whatever the law's accuracy.
        (Deviation::Bound { .. }, _)
            if metric
                .standard_error()
                .is_some_and(|error| (metric.value() - theory.value).abs() <= AGREES * error) =>
        {
            format!(", which agrees with {value} within its standard error")
        }
        _ => {
            // A difference in percent follows from the numbers that are shown.
            let [measured, expected] =
                [metric.value(), theory.value].map(|it| shown_value(it, metric));
            let shown = match deviation {
                Deviation::StandardErrors(sigma) => {
                    Deviation::StandardErrors(literal_errors(sigma, metric))
                }
                other => other,
            };
            let text = of_deviation(shown, measured, expected, theory.accuracy, &value);
            text + &chance(deviation, metric)
        }
    }
}

/// The deviation from theory for the start of this run, whose standard error is not that of the value.
fn conditional(sigma: f64, measured: f64, theory: f64, value: &str) -> String {
    if sigma.abs() <= AGREES {
        return format!(", which agrees with {value} for this start within the standard error");
    }
    let (difference, sigma) = (excess(measured, theory, value), significant(sigma.abs(), 2));
    format!("{difference} for this start, by {sigma} standard errors of the difference")
}

/// Of a deviation that scatter hardly explains, how rare it is and what follows.
fn chance(deviation: Deviation, metric: &Metric) -> String {
    match deviation {
        Deviation::StandardErrors(sigma) if sigma.abs() > UNLIKELY => {
            chance_words(sigma.abs(), &[metric])
        }
        _ => String::new(),
    }
}

fn of_deviation(
    deviation: Deviation,
    measured: f64,
    expected: f64,
    accuracy: f64,
    value: &str,
) -> String {
    match deviation {
        // A number that is 0, where 0 is expected, needs no words.
        _ if measured == 0.0 && expected == 0.0 => String::new(),
        Deviation::Rounding if expected == 0.0 => ", which is 0 up to rounding".to_owned(),
        Deviation::Rounding => format!(", equal to {value}"),
        Deviation::StandardErrors(sigma) if sigma.abs() <= AGREES => {
            format!(", which agrees with {value} within its standard error")
        }
        Deviation::StandardErrors(sigma) => {
            let words = match &*significant(sigma.abs(), 2) {
                "1" | "1.0" => "one standard error".to_owned(),
                number => format!("{number} standard errors"),
            };
            format!(", {words} {} {value}", side(sigma))
        }
        Deviation::Bound { is_inside } => {
            let place = if is_inside { "within" } else { "outside" };
            let bound = match accuracy / expected.abs() {
                relative if relative.is_finite() => {
                    format!("{} to which this law is accurate", percent(relative))
                }
                _ => "accuracy of this law".to_owned(),
            };
            format!("{}, {place} the {bound}", excess(measured, expected, value))
        }
        Deviation::Bare(_) => excess(measured, expected, value),
    }
}

/// A difference from an expected value without a standard error.
fn excess(measured: f64, expected: f64, value: &str) -> String {
    let difference = measured - expected;
    let relative = difference.abs() / expected.abs();
    if measured == expected {
        return String::new();
    }
    if expected == 0.0 || !relative.is_finite() {
        return format!(", compared with {value}");
    }
    if relative < SAME {
        return format!(", which equals {value} within {}", percent(relative));
    }
    if relative > LARGEST_EXCESS {
        return format!(", {} times {value}", significant(measured / expected, 2));
    }
    format!(", {} {} {value}", percent(relative), side(difference))
}

fn side(difference: f64) -> &'static str {
    if difference < 0.0 { "below" } else { "above" }
}

fn to_expected(metric: &Metric, expected: f64) -> String {
    let value = format!("the expected {}", in_unit(expected, metric));
    let difference = (metric.value() - expected).abs();
    if difference <= crate::metric::deviation::ROUNDING_FRACTION * expected.abs() {
        return if expected == 0.0 { String::new() } else { format!(", equal to {value}") };
    }
    excess(metric.value(), expected, &value)
}

fn in_range(minimum: Option<f64>, maximum: Option<f64>, metric: &Metric) -> String {
    let number = |value: f64| in_unit(value, metric);
    match (minimum, maximum) {
        (Some(minimum), Some(maximum)) => {
            let unit = unit_words(metric.unit());
            let from = number(minimum);
            let from = from.strip_suffix(&unit).unwrap_or(&from);
            format!(", within the required range of {from} to {}", number(maximum))
        }
        (Some(minimum), None) => format!(", where at least {} is required", number(minimum)),
        (None, Some(maximum)) => format!(", where at most {} is allowed", number(maximum)),
        (None, None) => String::new(),
    }
}

/// What a failed check requires, as the end of a sentence.
pub(super) fn requirement(check: &Check, metric: &Metric) -> String {
    let target = |expected: Option<f64>| match (expected, metric.theory_value()) {
        (Some(expected), _) => format!("the expected {}", theory_text(expected, metric)),
        (None, Some(theory)) => format!("the theoretical {}", theory_text(theory, metric)),
        (None, None) => "theory".to_owned(),
    };
    match check.bound {
        Bound::Near { expected, tolerance } => {
            format!(", not within {} of {}", in_unit(tolerance, metric), target(expected))
        }
        Bound::NearRelative { expected, relative_tolerance }
            if relative_tolerance < SAME_NUMBER =>
        {
            format!(", not equal to {}", target(expected))
        }
        Bound::NearRelative { expected, relative_tolerance } => {
            format!(", not within {} of {}", percent(relative_tolerance), target(expected))
        }
        Bound::WithinStandardErrors { expected, standard_errors } => {
            let limit = significant(standard_errors, 3);
            format!(", not within {limit} standard errors of {}", target(expected))
        }
        Bound::MaxDeviation { sigma } => {
            let limit = significant(sigma, 3);
            format!(", not within {limit} standard errors of {}", target(None))
        }
        Bound::Range { minimum, maximum } => in_range(minimum, maximum, metric)
            .replace(", within the required range of", ", outside the required range of"),
    }
}
