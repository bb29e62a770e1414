//! What is wrong with an answer, without the solution.

use crate::grading::answer::Answer;
use crate::grading::key::{Combination, Key, Tolerance};
use crate::grading::rerun::{MetricValue, Rerun, RerunPoint};
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::{Bound, Check};
use std::f64::consts::{PI, SQRT_2};

/// A stated error below this fraction of that of the rerun is too small: the rerun's own error scatters, and so does the student's.
const SMALLEST_ERROR: f64 = 0.5;
/// Deviation of a wrong value from the right one times a factor, as a fraction, up to which the factor is named.
const NEAR_FACTOR: f64 = 0.01;

/// Something that is wrong with an answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Finding {
    /// One word: `run`, `unit`, `error`, `replicates`, `factor`, `value`, `check`, `fault` or `hash`.
    pub(crate) kind: &'static str,
    /// What is wrong.
    pub(crate) text: String,
}

impl Finding {
    fn new(kind: &'static str, text: impl Into<String>) -> Self {
        Self { kind, text: text.into() }
    }
}

/// A value with its error.
#[derive(Clone, Copy, Debug)]
struct Combined {
    value: f64,
    error: Option<f64>,
}

/// Compares an answer with the rerun of its manifest. Empty: it is accepted.
pub(crate) fn findings(answer: &Answer, key: &Key, rerun: &Rerun) -> Vec<Finding> {
    let mut found = Vec::new();
    if answer.hash.as_ref().is_some_and(|hash| *hash != rerun.hash) {
        let text = "the hash is not that of these runs: the hand-in was edited afterward, or another version of the program wrote it";
        found.push(Finding::new("hash", text));
    }
    if let Some(fault) = &rerun.fault {
        found.push(Finding::new("fault", format!("the run fails: {}", one_line(fault))));
        return found;
    }
    let others = key.other_keys(&answer.experiment);
    let unit = key.units.iter().find(|(unit, _)| *unit == answer.unit);
    if unit.is_none() {
        let text = format!("`{}` is not a unit of this quantity", one_line(&answer.unit));
        found.push(Finding::new("unit", text));
    }
    let scale = unit.map_or(1.0, |(_, factor)| *factor);
    let (value, error) = (answer.value * scale, answer.standard_error * scale);
    let Some(right) = combined(rerun, &key.metric, key.combination) else {
        let text = "these runs give no value that answers the question";
        found.extend(other_run(&others, false));
        found.push(Finding::new("run", text));
        return found;
    };
    let is_right = is_near(value, error, right, key.tolerance);
    found.extend(other_run(&others, is_right));
    found.extend(wrong_error(answer, error, right, key));
    if !is_right {
        found.push(wrong_value(value, right, key, rerun));
    }
    if let Some(rejected) = key.check_rejects {
        found.extend(wrong_check(&answer.experiment.checks, key, rerun, right, rejected));
    }
    found
}

fn other_run(keys: &[String], is_right: bool) -> Option<Finding> {
    let listed: Vec<String> = keys.iter().map(|key| format!("`{}`", one_line(key))).collect();
    let text = match is_right {
        true => "the value is right for these runs, which are not those that the exercise asks for",
        false => "these are not the runs that the exercise asks for",
    };
    (!keys.is_empty()).then(|| Finding::new("run", format!("{text}: check {}", listed.join(", "))))
}

/// The value of a metric over all runs.
fn combined(rerun: &Rerun, metric: &str, combination: Combination) -> Option<Combined> {
    let mut points: Vec<(&RerunPoint, Vec<MetricValue>)> = Vec::new();
    for run in &rerun.runs {
        let value = *run.metrics.iter().find(|value| value.name == metric)?;
        match points.iter_mut().find(|(point, _)| point.coordinates == run.coordinates) {
            Some((_, values)) => values.push(value),
            None => points.push((run, vec![value])),
        }
    }
    let means: Vec<Combined> = points.iter().map(|(_, values)| mean(values)).collect();
    let (first, last) = (means.first()?, means.last()?);
    let ratio = last.value / first.value;
    let relative = |one: &Combined| Some(one.error? / one.value);
    let relative_error = relative(first).zip(relative(last)).map(|(a, b)| libm::hypot(a, b));
    match combination {
        Combination::Mean => {
            let all: Vec<MetricValue> = points.into_iter().flat_map(|(_, values)| values).collect();
            Some(mean(&all))
        }
        Combination::Ratio => {
            let error = relative_error.map(|error| (error * ratio).abs());
            Some(Combined { value: ratio, error })
        }
        Combination::Exponent => {
            let swept = |(point, _): &(&RerunPoint, Vec<MetricValue>)| {
                point.coordinates.first()?.value.parse::<f64>().ok()
            };
            let decades = libm::log(swept(points.last()?)? / swept(points.first()?)?);
            let error = relative_error.map(|error| (error / decades).abs());
            Some(Combined { value: libm::log(ratio) / decades, error })
        }
    }
}

/// The mean over replicates, with the error of their scatter; of one run, its own error.
fn mean(values: &[MetricValue]) -> Combined {
    let count = values.len() as f64;
    let value = values.iter().map(|one| one.value).sum::<f64>() / count;
    let squares: f64 = values.iter().map(|one| (one.value - value) * (one.value - value)).sum();
    let error = match values {
        [one] => one.error,
        _ => Some((squares / (count - 1.0) / count).sqrt()),
    };
    Combined { value, error }
}

fn is_near(value: f64, error: f64, right: Combined, tolerance: Tolerance) -> bool {
    let allowed = match tolerance {
        Tolerance::Relative(fraction) => fraction * right.value.abs(),
        Tolerance::StandardErrors(count) => count * libm::hypot(error, right.error.unwrap_or(0.0)),
    };
    (value - right.value).abs() <= allowed
}

fn wrong_error(answer: &Answer, error: f64, right: Combined, key: &Key) -> Vec<Finding> {
    let mut found = Vec::new();
    let replicates = answer.experiment.replicates as usize;
    if replicates < key.min_replicates {
        let text = format!("{replicates} of at least {} replicates", key.min_replicates);
        found.push(Finding::new("replicates", text));
    } else if right.error.is_some_and(|own| error < SMALLEST_ERROR * own) {
        let text = "the stated standard error is smaller than that of these runs: more replicates, or a larger error";
        found.push(Finding::new("error", text));
    }
    if key.max_relative_error.is_some_and(|most| error > most * right.value.abs()) {
        let text = "the stated standard error is too large to answer the question: more replicates or a longer run";
        found.push(Finding::new("error", text));
    }
    found
}

/// Factors that a formula or a unit often misses.
const FACTORS: [(f64, &str); 11] = [
    (2.0, "2"),
    (0.5, "1/2"),
    (SQRT_2, "sqrt(2)"),
    (1.0 / SQRT_2, "1/sqrt(2)"),
    (PI, "pi"),
    (1.0 / PI, "1/pi"),
    (2.0 * PI, "2 pi"),
    (0.5 / PI, "1/(2 pi)"),
    (180.0 / PI, "180/pi: degrees in place of radians"),
    (PI / 180.0, "pi/180: radians in place of degrees"),
    (-1.0, "-1: the sign"),
];
/// Decimal places of a unit's prefix that are named.
const DECADES: std::ops::RangeInclusive<i32> = -15..=15;
/// 0 °C in K.
const CELSIUS_K: f64 = 273.15;

/// Why a value is wrong, as far as it is known.
fn wrong_value(value: f64, right: Combined, key: &Key, rerun: &Rerun) -> Finding {
    let near = |other: f64| (value - other).abs() <= NEAR_FACTOR * other.abs();
    for wrong in &key.wrong {
        let by_factor = wrong.factor.is_some_and(|factor| near(factor * right.value));
        let by_metric = wrong.metric.as_ref().is_some_and(|metric| {
            combined(rerun, metric, key.combination).is_some_and(|other| near(other.value))
        });
        if by_factor || by_metric {
            return Finding::new("factor", wrong.hint.clone());
        }
    }
    if key.units.iter().any(|(unit, _)| unit == "K")
        && [-CELSIUS_K, CELSIUS_K].iter().any(|offset| near(right.value + offset))
    {
        return Finding::new("factor", "the value is off by 273.15: kelvin and degrees Celsius");
    }
    if let Some((_, name)) = FACTORS.iter().find(|(factor, _)| near(factor * right.value)) {
        return Finding::new("factor", format!("the value is off by a factor of {name}"));
    }
    if DECADES
        .filter(|places| *places != 0)
        .any(|places| near(libm::exp10(f64::from(places)) * right.value))
    {
        return Finding::new("factor", "the value is off by a power of ten: the prefix of a unit");
    }
    let text =
        "the value is not that of these runs: it may belong to another run or another quantity";
    Finding::new("value", text)
}

/// What is wrong with the checks of an answer.
fn wrong_check(
    checks: &[Check],
    key: &Key,
    rerun: &Rerun,
    right: Combined,
    rejected: f64,
) -> Option<Finding> {
    let metrics = rerun.runs.iter().flat_map(|run| &run.metrics);
    let theory = metrics.filter(|one| one.name == key.metric).find_map(|one| one.theory);
    let own: Vec<&Check> = checks.iter().filter(|check| check.metric == key.metric).collect();
    let passes = |check: &&Check, value: f64| {
        is_within(check.bound, Combined { value, ..right }, theory).unwrap_or(false)
    };
    let text = match own.as_slice() {
        [] => "the manifest has no [[checks]] of this quantity",
        own if !own.iter().all(|check| passes(check, right.value)) => {
            "a check fails for these runs"
        }
        own if own.iter().all(|check| passes(check, rejected)) => {
            "the check is too wide: it accepts a value that a wrong formula gives"
        }
        _ => return None,
    };
    Some(Finding::new("check", text))
}

/// Whether a value is within the bound of a check; `None` without what it is compared with.
fn is_within(bound: Bound, found: Combined, theory: Option<f64>) -> Option<bool> {
    let off = |expected: Option<f64>| Some((found.value - expected.or(theory)?).abs());
    let error = || found.error;
    Some(match bound {
        Bound::Near { expected, tolerance } => off(expected)? <= tolerance,
        Bound::NearRelative { expected, relative_tolerance } => {
            off(expected)? <= relative_tolerance * expected.or(theory)?.abs()
        }
        Bound::WithinStandardErrors { expected, standard_errors } => {
            off(expected)? <= standard_errors * error()?
        }
        Bound::MaxDeviation { sigma } => off(None)? <= sigma * error()?,
        Bound::Range { minimum, maximum } => {
            minimum.is_none_or(|least| found.value >= least)
                && maximum.is_none_or(|most| found.value <= most)
        }
    })
}
