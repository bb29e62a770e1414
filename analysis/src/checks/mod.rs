//! Checks: compares metrics with the bounds of the manifest or a checks file.

pub(crate) mod baseline;
pub(crate) mod ci_formats;
pub(crate) mod outcome;

use crate::input::coordinates;
use crate::metric::{Deviation, Metric, MetricScope};
use kinetoscope_console::text::visible;
use kinetoscope_manifest::{Bound, Check, IfUndecided};
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
    /// The name of the run in a test report, where the subject is its file.
    pub(crate) run: Option<String>,
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

/// The metrics that a check selects: fits and means over replicates if there are any, else each run that is complete, or each that failed
/// if none is.
pub(crate) fn checked_metrics<'a>(check: &Check, metrics: &'a [Metric]) -> Vec<&'a Metric> {
    let named = metrics.iter().filter(|metric| metric.name() == check.metric);
    let selected: Vec<&Metric> =
        named.filter(|metric| check.selects(metric.coordinates())).collect();
    let means: BTreeSet<String> = selected
        .iter()
        .filter(|metric| matches!(metric.scope, MetricScope::Sweep(_)))
        .map(|metric| coordinates::text(metric.coordinates()))
        .collect();
    let outcome_of = |metric: &Metric| match &metric.scope {
        MetricScope::Sweep(_) => "complete",
        MetricScope::Run(run) => run.outcome,
    };
    // The end of a run that failed is no result, unless all runs do so, as expected.
    let has_complete = selected.iter().any(|metric| outcome_of(metric) == "complete");
    let is_checked = |metric: &&Metric| match &metric.scope {
        MetricScope::Sweep(_) => true,
        MetricScope::Run(run) => {
            let whole = run.outcome == "complete" || (run.outcome == "fault" && !has_complete);
            whole && !means.contains(&coordinates::text(&run.coordinates))
        }
    };
    selected.into_iter().filter(is_checked).collect()
}

/// Evaluates a check for every metric that it selects. A check without a metric fails.
pub(crate) fn evaluate(check: &Check, metrics: &[Metric]) -> Vec<CheckResult> {
    let checked = checked_metrics(check, metrics);
    if checked.is_empty() {
        let named = metrics.iter().filter(|metric| metric.name() == check.metric);
        return vec![missing(check, &named.collect::<Vec<_>>())];
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
        run: None,
        requirement: requirement(check.bound),
        finding: why,
        file: None,
        line: check.line,
        seconds: 0.0,
    }
}

/// Compares a metric with a check's bound. A metric that lacks what the bound needs is undecided.
pub(crate) fn compare(check: &Check, metric: &Metric) -> CheckResult {
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
        run: None,
        requirement: requirement(check.bound),
        finding,
        file: None,
        line: check.line,
        seconds: 0.0,
    }
}

/// Why a metric cannot be compared with a check's bound; `None` if it can.
pub(crate) fn undecided_because(check: &Check, metric: &Metric) -> Option<String> {
    holds(check.bound, metric).err()
}

const NO_THEORY: &str = "which has no theoretical value: give `expected`";
const NO_ERROR: &str = "which has no standard error: give `tolerance` or `relative_tolerance`, or, if the model uses random numbers, record replicates";

const NO_SIGMA: &str = "the violation of a conservation law, which has no deviation in standard errors: give `maximum`, or `tolerance`";

/// Whether a metric is within a bound, and the expectation as text.
///
/// # Errors
/// What the metric lacks.
fn holds(bound: Bound, metric: &Metric) -> Result<(bool, String), String> {
    let measured = metric.value();
    if let Some(reason) = &metric.reason {
        return Err(reason.to_string());
    }
    let theory = || {
        let theory = metric.theory.ok_or(NO_THEORY)?;
        theory.out_of_range().map_or(Ok(theory.value), Err)
    };
    let no_error = || match metric.estimate.missing_error {
        _ if metric.is_of_conservation_law() => NO_SIGMA.to_owned(),
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
            let deviation =
                given.map_or_else(|| metric.deviation(), |_| metric.deviation_from(expected));
            let (passed, text) = within_sigma(deviation, standard_errors).ok_or_else(no_error)?;
            (passed, format!("{} with {text}", digits(expected)))
        }
        Bound::MaxDeviation { sigma } => {
            let deviation = theory().map(|_| metric.deviation())?;
            within_sigma(deviation, sigma).ok_or_else(no_error)?
        }
        Bound::Range { minimum, maximum } => {
            let above = minimum.is_none_or(|minimum| measured >= minimum);
            let below = maximum.is_none_or(|maximum| measured <= maximum);
            (above && below && !measured.is_nan(), range_text(minimum, maximum))
        }
    })
}

/// Whether a deviation is within a limit in standard errors, and the limit as text; `None` if no error is known.
fn within_sigma(deviation: Option<Deviation>, limit: f64) -> Option<(bool, String)> {
    match deviation? {
        Deviation::Rounding => Some((true, "no deviation beyond rounding".to_owned())),
        Deviation::StandardErrors(deviation) => {
            let text = format!("a deviation of at most {limit} σ, found {deviation:.2} σ");
            Some((deviation.abs() <= limit, text))
        }
        Deviation::Bound { is_inside } => {
            let place = if is_inside { "inside" } else { "outside" };
            Some((is_inside, format!("a value inside the accuracy of the law, found {place}")))
        }
        Deviation::Bare(_) => None,
    }
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
    use crate::metric::theory::{Expected, Theory};
    use crate::statistics::random::Uniform;
    use crate::statistics::{Estimate, mean_of_independent};

    const SLOPE: &Definition = &Definition {
        name: "slope",
        unit: "m",
        label: "quantity",
        how: "",
        laws: &[],
        rounding: 0.0,
    };

    fn metric(value: f64, standard_error: Option<f64>, theory: Option<f64>) -> Metric {
        let estimate = Estimate::new(value, standard_error);
        let theory = theory.expected().map(|expected| expected.by(None));
        let scope =
            MetricScope::Sweep(SweepScope { along: None, coordinates: Vec::new(), replicates: 1 });
        Metric::new(SLOPE, estimate, theory, scope)
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

    /// Law: the mean of two normal values deviates by more than "4 standard errors" of Student's t in 6e-5 of all cases.
    /// Setup: 2000 cases. Control: 16 % exceed 4 times their own
    /// standard error, and against an exact law the same value fails. An accuracy larger than the error is a bound, whose third part is
    /// inside and whose triple is not.
    #[test]
    fn standard_errors_follow_students_t_and_include_the_accuracy_of_the_law() {
        let mut uniform = Uniform(15);
        let bound = Bound::WithinStandardErrors { expected: None, standard_errors: 4.0 };
        let given = Bound::WithinStandardErrors { expected: Some(7.0), standard_errors: 4.0 };
        let (mut failed, mut beyond) = (0, 0);
        for _ in 0..2000 {
            let values = [7.0 + uniform.normal(), 7.0 + uniform.normal()];
            let estimate = mean_of_independent(&values).unwrap();
            let found = Metric { estimate, ..metric(0.0, None, Some(7.0)) };
            assert_eq!(passes(bound, &found), passes(given, &found));
            failed += u32::from(!passes(bound, &found));
            let t = (estimate.value - 7.0) / estimate.standard_error.unwrap();
            beyond += u32::from(t.abs() > 4.0);
        }
        assert!(failed <= 2 && beyond > 200, "{failed} of 2000 fail, control: {beyond}");
        let inexact = metric(10.1, Some(0.01), Some(10.0));
        assert!(!passes(bound, &inexact));
        let with = |accuracy: f64| {
            let theory = inexact.theory.map(|theory| Theory { accuracy, ..theory });
            Metric { theory, ..inexact.clone() }
        };
        assert!(passes(bound, &with(0.3)) && !passes(bound, &with(0.03)));
        let inexact = with(0.3);
        // A given value has no law.
        let expected = Bound::WithinStandardErrors { expected: Some(10.0), standard_errors: 4.0 };
        assert!(!passes(expected, &inexact));
    }

    /// A largest energy error has a standard error from its replicates, and is never compared by it. Control: by another law, it is.
    #[test]
    fn check_of_a_conservation_law_in_standard_errors_names_the_bounds_that_apply() {
        let finding = |is_conservation: bool| {
            let found = metric(1e-4, Some(1e-5), Some(0.0));
            let law = crate::metric::Law {
                statement: "",
                source: "",
                range: "",
                relative_accuracy: 0.0,
                conserved: is_conservation.then_some("energy"),
                name: None,
                is_of_integrator: false,
                is_identity: false,
                is_of_manifest: false,
            };
            let theory =
                found.theory.map(|theory| Theory { law: Some(Box::leak(Box::new(law))), ..theory });
            let check = Check {
                metric: "slope".to_owned(),
                at: Vec::new(),
                bound: Bound::WithinStandardErrors { expected: None, standard_errors: 4.0 },
                if_undecided: IfUndecided::Fail,
                line: 0,
            };
            evaluate(&check, &[Metric { theory, ..found }]).remove(0).finding
        };
        let of_conservation = finding(true);
        assert!(of_conservation.contains("conservation law"), "{of_conservation}");
        assert!(of_conservation.contains("`maximum`"), "{of_conservation}");
        assert!(!of_conservation.contains("record replicates"), "{of_conservation}");
        assert!(finding(false).contains("found 10.00 σ"), "{}", finding(false));
    }

    #[test]
    fn metric_without_theory_or_error_fails() {
        let bare = metric(10.0, None, None);
        assert!(!passes(Bound::Near { expected: None, tolerance: 1.0 }, &bare));
        let of = |expected| Bound::WithinStandardErrors { expected, standard_errors: 9.0 };
        assert!(!passes(of(Some(11.0)), &bare) && !passes(of(None), &bare));
        // Rounding passes without an error, as for a deviation.
        assert!(passes(of(Some(10.0)), &bare));
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
