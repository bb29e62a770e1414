//! Checks: compares metrics with the bounds of the manifest or a checks file.

pub(crate) mod baseline;
pub(crate) mod ci_formats;
pub(crate) mod outcome;

use crate::input::coordinates;
use crate::metric::{Deviation, Metric, MetricScope};
use kinetoscope_manifest::{Bound, Check, IfUndecided};
use kinetoscope_usage::text::visible;
use std::collections::BTreeSet;

/// The result of a check, or of a comparison with a baseline, for one metric.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CheckResult {
    /// Whether the check passed.
    pub(crate) passed: bool,
    /// What the metric was compared with.
    pub(crate) kind: CheckKind,
    /// The metric and its scope.
    pub(crate) subject: String,
    /// What the manifest requires, such as "within 4 standard errors".
    pub(crate) requirement: String,
    /// The measured value, the expected value, and the tolerance.
    pub(crate) finding: String,
    /// The file of the check, if that is not the manifest.
    pub(crate) file: Option<String>,
    /// The check's line in its file, from 1; 0 if it has none.
    pub(crate) line: u32,
    /// Time that the analysis of the run took, s; 0 for a check.
    pub(crate) seconds: f64,
}

/// What a metric is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CheckKind {
    /// The outcome that the manifest expects of a run.
    Outcome,
    /// The bounds of a check in the manifest or in a checks file.
    Check,
    /// The metrics of an earlier analysis.
    Baseline,
}

impl CheckResult {
    /// The result in one line.
    pub(crate) fn text(&self) -> String {
        format!("{}: {}", self.subject, self.finding)
    }
}

/// Evaluates a check for every metric that it selects: fits and means over replicates if there are any, else each run.
/// A check without a metric fails.
pub(crate) fn evaluate(check: &Check, metrics: &[Metric]) -> Vec<CheckResult> {
    let named: Vec<&Metric> =
        metrics.iter().filter(|metric| metric.name() == check.metric).collect();
    let selected: Vec<&Metric> =
        named.iter().copied().filter(|metric| check.selects(metric.coordinates())).collect();
    let means: BTreeSet<String> = selected
        .iter()
        .filter(|metric| matches!(metric.scope, MetricScope::Sweep(_)))
        .map(|metric| coordinates::text(metric.coordinates()))
        .collect();
    let checked: Vec<&Metric> = selected
        .into_iter()
        .filter(|metric| match &metric.scope {
            MetricScope::Sweep(_) => true,
            MetricScope::Run(run) => {
                let whole = matches!(run.outcome, "complete" | "fault");
                whole && !means.contains(&coordinates::text(&run.coordinates))
            }
        })
        .collect();
    if checked.is_empty() {
        return vec![missing(check, &named)];
    }
    checked.into_iter().map(|metric| compare(check, metric)).collect()
}

fn missing(check: &Check, named: &[&Metric]) -> CheckResult {
    let place = check.at.iter().map(|(key, value)| format!("{key} = {value}"));
    let place = place.collect::<Vec<_>>().join(", ");
    let place = if place.is_empty() { String::new() } else { format!(" at {place}") };
    let why = if named.is_empty() {
        format!("no finished run{place} has this metric")
    } else {
        format!("there is none of a finished run{place}")
    };
    CheckResult {
        passed: false,
        kind: CheckKind::Check,
        subject: check.metric.clone(),
        requirement: requirement(check.bound),
        finding: why,
        file: None,
        line: check.line,
        seconds: 0.0,
    }
}

/// Compares a metric with a check's bound. A metric that lacks what the bound needs is undecided.
fn compare(check: &Check, metric: &Metric) -> CheckResult {
    let measured = if metric.value().is_finite() {
        format!("measured {}", in_unit(metric.value(), metric))
    } else {
        "no value".to_owned()
    };
    let (passed, finding) = match holds(check.bound, metric) {
        Ok((passed, expectation)) => (passed, format!("{measured}, expected {expectation}")),
        Err(missing) => {
            (check.if_undecided == IfUndecided::Pass, format!("undecided: {measured}, {missing}"))
        }
    };
    CheckResult {
        passed,
        kind: CheckKind::Check,
        subject: subject(metric),
        requirement: requirement(check.bound),
        finding,
        file: None,
        line: check.line,
        seconds: 0.0,
    }
}

const NO_THEORY: &str = "which has no theoretical value: give `expected`";
const NO_ERROR: &str = "which has no standard error: record more frames or replicates";

/// Whether a metric is within a bound, and the expectation as text.
///
/// # Errors
/// What the metric lacks.
fn holds(bound: Bound, metric: &Metric) -> Result<(bool, String), String> {
    let measured = metric.value();
    if let Some(reason) = &metric.reason {
        return Err(reason.to_string());
    }
    let theory = || match metric.theory {
        Some(theory) if theory.in_range => Ok(theory.value),
        Some(theory) => Err(theory.out_of_range()),
        None => Err(NO_THEORY.to_owned()),
    };
    let no_error = || match metric.estimate.missing_error {
        Some(missing) => missing.to_string(),
        None => NO_ERROR.to_owned(),
    };
    let expected_or_theory = |expected: Option<f64>| expected.map_or_else(theory, Ok);
    Ok(match bound {
        Bound::Near { expected, tolerance } => {
            within(measured, expected_or_theory(expected)?, tolerance)
        }
        Bound::NearRelative { expected, relative_tolerance } => {
            let expected = expected_or_theory(expected)?;
            let (passed, text) = within(measured, expected, relative_tolerance * expected.abs());
            (passed, format!("{text} ({relative_tolerance} of it)"))
        }
        Bound::WithinStandardErrors { expected: given, standard_errors } => {
            let expected = expected_or_theory(given)?;
            let conditional = metric.estimate.conditional_standard_error;
            // A given value does not follow the start of the run, as theory does.
            let error = conditional.filter(|_| given.is_none()).or(metric.standard_error());
            let error = error.ok_or_else(no_error)?;
            let (passed, text) = within(measured, expected, standard_errors * error);
            (passed, format!("{text} ({standard_errors} standard errors)"))
        }
        Bound::MaxDeviation { sigma } => match theory().map(|_| metric.deviation())? {
            None => return Err(no_error()),
            Some(Deviation::Rounding) => (true, "theory's value, up to rounding".to_owned()),
            Some(Deviation::StandardErrors(deviation)) => {
                let text = format!("a deviation of at most {sigma} σ, found {deviation:.2} σ");
                (deviation.abs() <= sigma, text)
            }
            Some(Deviation::Bare(_)) => return Err(no_error()),
        },
        Bound::Range { minimum, maximum } => {
            let above = minimum.is_none_or(|minimum| measured >= minimum);
            let below = maximum.is_none_or(|maximum| measured <= maximum);
            (above && below && !measured.is_nan(), range_text(minimum, maximum))
        }
    })
}

fn range_text(minimum: Option<f64>, maximum: Option<f64>) -> String {
    match (minimum, maximum) {
        (Some(minimum), Some(maximum)) => format!("{} to {}", digits(minimum), digits(maximum)),
        (Some(minimum), None) => format!("at least {}", digits(minimum)),
        (None, Some(maximum)) => format!("at most {}", digits(maximum)),
        (None, None) => "anything".to_owned(),
    }
}

/// A bound as text, without the measured value.
fn requirement(bound: Bound) -> String {
    let target = |expected: Option<f64>| expected.map_or_else(|| "theory".to_owned(), digits);
    match bound {
        Bound::Near { expected, tolerance } => {
            format!("within {} of {}", digits(tolerance), target(expected))
        }
        Bound::NearRelative { expected, relative_tolerance } => {
            format!("within a fraction {} of {}", digits(relative_tolerance), target(expected))
        }
        Bound::WithinStandardErrors { expected, standard_errors } => {
            format!("within {} standard errors of {}", digits(standard_errors), target(expected))
        }
        Bound::MaxDeviation { sigma } => format!("within {} sigma of theory", digits(sigma)),
        Bound::Range { minimum, maximum } => range_text(minimum, maximum),
    }
}

/// Text from a file in one line: with spaces in place of line breaks, so that no part of it starts a line.
pub(crate) fn one_line(text: &str) -> String {
    let text = visible(text);
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ")
}

/// Formats a value with seven digits and its unit.
pub(crate) fn in_unit(value: f64, metric: &Metric) -> String {
    match metric.unit() {
        "" | "1" => digits(value),
        unit => format!("{} {unit}", digits(value)),
    }
}

/// The metric's name with its run or part of the sweep.
pub(crate) fn subject(metric: &Metric) -> String {
    format!("{}{}", metric.name(), place_text(metric))
}

fn within(measured: f64, expected: f64, tolerance: f64) -> (bool, String) {
    // NaN is outside every tolerance.
    let passed = (measured - expected).abs() <= tolerance;
    (passed, format!("{} ± {}", digits(expected), digits(tolerance)))
}

/// Formats a value with seven digits, with a power of ten if it is very large or small.
pub(crate) fn digits(value: f64) -> String {
    let text = format!("{value:.6e}");
    let trimmed = |digits: &str| digits.trim_end_matches('0').trim_end_matches('.').to_owned();
    match text.split_once('e').map(|(mantissa, exponent)| (mantissa, exponent.parse::<i32>())) {
        Some((_, Ok(exponent @ -3..=5))) => {
            let decimals = usize::try_from(6 - exponent).unwrap_or(0);
            trimmed(&format!("{value:.decimals$}"))
        }
        Some((mantissa, Ok(exponent))) => format!("{}e{exponent}", trimmed(mantissa)),
        _ => text,
    }
}

fn place_text(metric: &Metric) -> String {
    let mut place = coordinates::text(metric.coordinates());
    if let MetricScope::Run(run) = &metric.scope
        && run.replicate > 0
    {
        let separator = if place.is_empty() { "" } else { ", " };
        place = format!("{place}{separator}replicate = {}", run.replicate);
    }
    if place.is_empty() { place } else { format!(" at {place}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::SweepScope;
    use crate::metric::definition::Definition;
    use crate::metric::theory::Expected;
    use crate::statistics::Estimate;

    const SLOPE: &Definition =
        &Definition { name: "slope", unit: "m", how: "", laws: &[], rounding: 0.0 };

    fn metric(value: f64, standard_error: Option<f64>, theory: Option<f64>) -> Metric {
        let estimate = Estimate::new(value, standard_error);
        let theory = theory.expected().map(|expected| expected.by(None));
        let scope =
            MetricScope::Sweep(SweepScope { along: None, coordinates: Vec::new(), replicates: 1 });
        Metric::new(SLOPE, estimate, theory, String::new(), scope)
    }

    fn passes(bound: Bound, metric: &Metric) -> bool {
        let check = Check {
            metric: "slope".to_owned(),
            at: Vec::new(),
            bound,
            if_undecided: IfUndecided::Fail,
            line: 0,
        };
        let check_results = evaluate(&check, std::slice::from_ref(metric));
        assert_eq!(check_results.len(), 1);
        check_results[0].passed
    }

    #[test]
    fn each_bound_holds_up_to_its_edge_and_not_beyond() {
        let found = metric(10.5, Some(0.25), Some(10.0));
        let near = |tolerance| Bound::Near { expected: Some(10.0), tolerance };
        assert!(passes(near(0.5), &found) && !passes(near(0.4), &found));
        let relative =
            |relative_tolerance| Bound::NearRelative { expected: None, relative_tolerance };
        assert!(passes(relative(0.05), &found) && !passes(relative(0.04), &found));
        let errors =
            |standard_errors| Bound::WithinStandardErrors { expected: None, standard_errors };
        assert!(passes(errors(2.0), &found) && !passes(errors(1.9), &found));
        let deviation = |sigma| Bound::MaxDeviation { sigma };
        assert!(passes(deviation(2.0), &found) && !passes(deviation(1.9), &found));
        let range = |minimum, maximum| Bound::Range { minimum, maximum };
        assert!(passes(range(Some(10.5), Some(10.5)), &found));
        assert!(
            !passes(range(None, Some(10.4)), &found) && !passes(range(Some(10.6), None), &found)
        );
    }

    #[test]
    fn metric_without_theory_or_error_fails() {
        let bare = metric(10.0, None, None);
        assert!(!passes(Bound::Near { expected: None, tolerance: 1.0 }, &bare));
        assert!(!passes(
            Bound::WithinStandardErrors { expected: Some(10.0), standard_errors: 9.0 },
            &bare
        ));
        assert!(!passes(Bound::MaxDeviation { sigma: 9.0 }, &bare));
        assert!(!passes(Bound::MaxDeviation { sigma: 9.0 }, &metric(1.0, None, Some(2.0))));
        let broken = metric(f64::NAN, None, None);
        assert!(!passes(Bound::Range { minimum: None, maximum: Some(1.0) }, &broken));
        assert!(!passes(Bound::Near { expected: Some(0.0), tolerance: 1e300 }, &broken));
        let check = Check {
            metric: "slop".to_owned(),
            at: Vec::new(),
            bound: Bound::Range { minimum: None, maximum: Some(1.0) },
            if_undecided: IfUndecided::Pass,
            line: 0,
        };
        // A metric without a value is undecided, with its reason.
        let explained = Metric { reason: Some("the radii differ".into()), ..broken };
        let undecided = Check { metric: "slope".to_owned(), ..check.clone() };
        let found = evaluate(&undecided, &[explained]).remove(0);
        assert!(
            found.passed && found.finding == "undecided: no value, the radii differ",
            "{found:?}"
        );
        let check_results = evaluate(&check, &[bare]);
        assert!(!check_results[0].passed, "a missing metric fails even if undecided checks pass");
    }
}
