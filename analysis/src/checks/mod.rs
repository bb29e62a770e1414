//! Checks: compares metrics with the bounds of the manifest or a checks file.

pub(crate) mod baseline;
pub(crate) mod ci_formats;

use crate::input::coordinates;
use crate::metric::{Metric, MetricScope};
use crate::models;
use kinetoscope_manifest::{Bound, Check};
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
    /// The measured value, the expected value, and the tolerance.
    pub(crate) finding: String,
}

/// What a metric is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CheckKind {
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
                let whole = run.outcome == "complete" || run.outcome.starts_with("fault");
                whole && !means.contains(&coordinates::text(&run.coordinates))
            }
        })
        .collect();
    if checked.is_empty() {
        return vec![missing(check, &named, metrics)];
    }
    checked.into_iter().map(|metric| compare(check, metric)).collect()
}

fn missing(check: &Check, named: &[&Metric], metrics: &[Metric]) -> CheckResult {
    let place = check.at.iter().map(|(key, value)| format!("{key} = {value}"));
    let place = place.collect::<Vec<_>>().join(", ");
    let why = if !named.is_empty() {
        let place =
            if place.is_empty() { "of a finished run".to_owned() } else { format!("at {place}") };
        format!("there is none {place}")
    } else {
        match models::nearest(metrics.iter().map(Metric::name), &check.metric) {
            Some(name) => format!("there is no such metric; did you mean {name}?"),
            None => "there is no such metric; metrics.csv lists all that there are".to_owned(),
        }
    };
    CheckResult {
        passed: false,
        kind: CheckKind::Check,
        subject: check.metric.clone(),
        finding: why,
    }
}

fn compare(check: &Check, metric: &Metric) -> CheckResult {
    let measured = metric.value;
    let expected_or_theory = |expected: Option<f64>| expected.or(metric.theory);
    let (passed, expectation) = match check.bound {
        Bound::Near { expected, tolerance } => within(measured, expected_or_theory(expected), tolerance),
        Bound::NearRelative { expected, relative_tolerance } => {
            let expected = expected_or_theory(expected);
            let tolerance = expected.map_or(0.0, |expected| relative_tolerance * expected.abs());
            let (passed, text) = within(measured, expected, tolerance);
            (passed, format!("{text} ({relative_tolerance} of it)"))
        }
        Bound::WithinStandardErrors { expected, standard_errors } => match metric.standard_error {
            Some(error) => {
                let (passed, text) =
                    within(measured, expected_or_theory(expected), standard_errors * error);
                (passed, format!("{text} ({standard_errors} standard errors)"))
            }
            None => (false, "a standard error, which this metric does not have: record more frames or replicates".to_owned()),
        },
        Bound::Range { minimum, maximum } => {
            let above = minimum.is_none_or(|minimum| measured >= minimum);
            let below = maximum.is_none_or(|maximum| measured <= maximum);
            let text = match (minimum, maximum) {
                (Some(minimum), Some(maximum)) => format!("{} to {}", digits(minimum), digits(maximum)),
                (Some(minimum), None) => format!("at least {}", digits(minimum)),
                (None, Some(maximum)) => format!("at most {}", digits(maximum)),
                (None, None) => "anything".to_owned(),
            };
            (above && below && !measured.is_nan(), text)
        }
    };
    let measured = in_unit(measured, metric);
    let finding = format!("measured {measured}, expected {expectation}");
    CheckResult { passed, kind: CheckKind::Check, subject: subject(metric), finding }
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

fn within(measured: f64, expected: Option<f64>, tolerance: f64) -> (bool, String) {
    match expected {
        Some(expected) => {
            // NaN is outside every tolerance.
            let passed = (measured - expected).abs() <= tolerance;
            (passed, format!("{} ± {}", digits(expected), digits(tolerance)))
        }
        None => {
            (false, "theory's value, which this metric does not have: give `expected`".to_owned())
        }
    }
}

/// Formats a value with seven digits, with a power of ten if it is very large or small.
fn digits(value: f64) -> String {
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

    const SLOPE: &Definition =
        &Definition { name: "slope", unit: "m", how: "", laws: &[], rounding: 0.0 };

    fn metric(value: f64, standard_error: Option<f64>, theory: Option<f64>) -> Metric {
        Metric {
            definition: SLOPE,
            value,
            standard_error,
            theory,
            rounding: 0.0,
            source: String::new(),
            scope: MetricScope::Sweep(SweepScope {
                along: None,
                coordinates: Vec::new(),
                replicates: 1,
            }),
        }
    }

    fn holds(bound: Bound, metric: &Metric) -> bool {
        let check = Check { metric: "slope".to_owned(), at: Vec::new(), bound };
        let check_results = evaluate(&check, std::slice::from_ref(metric));
        assert_eq!(check_results.len(), 1);
        check_results[0].passed
    }

    #[test]
    fn each_bound_holds_up_to_its_edge_and_not_beyond() {
        let found = metric(10.5, Some(0.25), Some(10.0));
        let near = |tolerance| Bound::Near { expected: Some(10.0), tolerance };
        assert!(holds(near(0.5), &found) && !holds(near(0.4), &found));
        let relative =
            |relative_tolerance| Bound::NearRelative { expected: None, relative_tolerance };
        assert!(holds(relative(0.05), &found) && !holds(relative(0.04), &found));
        let errors =
            |standard_errors| Bound::WithinStandardErrors { expected: None, standard_errors };
        assert!(holds(errors(2.0), &found) && !holds(errors(1.9), &found));
        let range = |minimum, maximum| Bound::Range { minimum, maximum };
        assert!(holds(range(Some(10.5), Some(10.5)), &found));
        assert!(!holds(range(None, Some(10.4)), &found) && !holds(range(Some(10.6), None), &found));
    }

    #[test]
    fn metric_without_theory_or_error_fails() {
        let bare = metric(10.0, None, None);
        assert!(!holds(Bound::Near { expected: None, tolerance: 1.0 }, &bare));
        assert!(!holds(
            Bound::WithinStandardErrors { expected: Some(10.0), standard_errors: 9.0 },
            &bare
        ));
        let broken = metric(f64::NAN, None, None);
        assert!(!holds(Bound::Range { minimum: None, maximum: Some(1.0) }, &broken));
        assert!(!holds(Bound::Near { expected: Some(0.0), tolerance: 1e300 }, &broken));
        let check = Check {
            metric: "slop".to_owned(),
            at: Vec::new(),
            bound: Bound::Range { minimum: None, maximum: Some(1.0) },
        };
        let check_results = evaluate(&check, &[bare]);
        assert!(
            !check_results[0].passed && check_results[0].finding.contains("did you mean slope")
        );
    }
}
