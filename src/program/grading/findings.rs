//! What is wrong with an answer, without the solution.

use crate::grading::answer::Answer;
use crate::grading::key::{Combination, Key, Tolerance};
use crate::grading::rerun::{MetricValue, Rerun, RerunPoint};
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::{Bound, Check};
use std::f64::consts::{PI, SQRT_2};

/// A stated error below this fraction of that of the rerun is too small: the rerun's own error scatters, and so does the student's.
const SMALLEST_ERROR: f64 = 0.5;
/// A stated error above this multiple of that of the rerun is too large: the runs are the student's own.
const LARGEST_ERROR: f64 = 2.0;
/// An error below this fraction of its value is round-off.
const ROUND_OFF: f64 = 1e-9;
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
    /// The error if points of a sweep with the same replicate belong together: they share random numbers.
    paired_error: Option<f64>,
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
    let spaceless = |unit: &str| unit.replace(char::is_whitespace, "");
    let unit = key.units.iter().find(|(unit, _)| spaceless(unit) == answer.unit);
    if unit.is_none() {
        let accepted: Vec<&str> = key.units.iter().map(|(unit, _)| unit.as_str()).collect();
        let (stated, accepted) = (one_line(&answer.unit), accepted.join(", "));
        let text = format!("`{stated}` is not among the units that are accepted here: {accepted}");
        found.push(Finding::new("unit", text));
    }
    let Some(right) = combined(rerun, &key.metric, key.combination) else {
        let text = "these runs give no value that answers the question";
        found.extend(other_run(&others, false));
        found.push(Finding::new("run", text));
        return found;
    };
    let stated =
        unit.map(|(_, factor)| (answer.value * factor, answer.standard_error * factor, *factor));
    let is_right =
        stated.is_some_and(|(value, error, _)| is_near(value, error, right, key.tolerance));
    found.extend(other_run(&others, is_right));
    found.extend(too_few_replicates(answer, key));
    if let Some((value, error, stated_in)) = stated {
        found.extend(wrong_error(error, right, key));
        found.extend((!is_right).then(|| wrong_value(value, stated_in, right, key, rerun)));
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
    if combination == Combination::Mean {
        let all: Vec<MetricValue> = points.into_iter().flat_map(|(_, values)| values).collect();
        return Some(mean(&all));
    }
    let ((first_point, first), (last_point, last)) = (points.first()?, points.last()?);
    let swept = |point: &RerunPoint| point.coordinates.first()?.value.parse::<f64>().ok();
    let logarithm = match combination {
        Combination::Exponent => Some(libm::log(swept(last_point)? / swept(first_point)?)),
        Combination::Mean | Combination::Ratio => None,
    };
    let of_ratio = |ratio: f64| logarithm.map_or(ratio, |it| libm::log(ratio) / it);
    let pairs = first.iter().zip(last);
    let each: Vec<f64> = pairs.map(|(first, last)| of_ratio(last.value / first.value)).collect();
    let (first, last) = (mean(first), mean(last));
    let ratio = last.value / first.value;
    let relative = |one: Combined| Some(one.error? / one.value);
    let relative_error = relative(first).zip(relative(last)).map(|(a, b)| libm::hypot(a, b));
    let error = relative_error.map(|error| logarithm.map_or(error * ratio, |it| error / it).abs());
    Some(Combined { value: of_ratio(ratio), error, paired_error: scatter(&each).or(error) })
}

/// The mean over replicates, with the error of their scatter; of one run, its own error.
fn mean(values: &[MetricValue]) -> Combined {
    let all: Vec<f64> = values.iter().map(|one| one.value).collect();
    let error = scatter(&all).or_else(|| values.first()?.error);
    Combined { value: mean_of(&all), error, paired_error: error }
}

fn mean_of(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The error of the mean from the scatter of its values; `None` for one value.
fn scatter(values: &[f64]) -> Option<f64> {
    let (count, mean) = (values.len() as f64, mean_of(values));
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    (values.len() > 1).then(|| (squares / (count - 1.0) / count).sqrt())
}

fn is_near(value: f64, error: f64, right: Combined, tolerance: Tolerance) -> bool {
    let allowed = match tolerance {
        Tolerance::Relative(fraction) => fraction * right.value.abs(),
        Tolerance::StandardErrors(count) => count * libm::hypot(error, right.error.unwrap_or(0.0)),
    };
    (value - right.value).abs() <= allowed
}

fn too_few_replicates(answer: &Answer, key: &Key) -> Option<Finding> {
    let replicates = answer.experiment.replicates as usize;
    (replicates < key.min_replicates).then(|| {
        let text = format!("{replicates} of at least {} replicates", key.min_replicates);
        Finding::new("replicates", text)
    })
}

fn wrong_error(error: f64, right: Combined, key: &Key) -> Option<Finding> {
    let (one, other) = (right.error.unwrap_or(0.0), right.paired_error.unwrap_or(0.0));
    let (smaller, larger) = if one < other { (one, other) } else { (other, one) };
    let value = right.value.abs();
    let most = match key.tolerance {
        Tolerance::Relative(fraction) if larger <= ROUND_OFF * value => fraction * value,
        _ => LARGEST_ERROR * larger,
    };
    let text = if smaller > ROUND_OFF * value && error < SMALLEST_ERROR * smaller {
        "the stated standard error is smaller than that of these runs: more replicates, or a larger error"
    } else if error > most {
        "the stated standard error is larger than that of these runs"
    } else if key.max_relative_error.is_some_and(|most| error > most * value) {
        "the stated standard error is too large to answer the question: more replicates or a longer run"
    } else {
        return None;
    };
    Some(Finding::new("error", text))
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

/// Why a value is wrong, as far as it is known. It was stated in a unit with this factor to that of the key.
fn wrong_value(value: f64, stated_in: f64, right: Combined, key: &Key, rerun: &Rerun) -> Finding {
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
    let in_other_unit = |other: f64| other != stated_in && near(right.value * stated_in / other);
    if key.units.iter().any(|(_, other)| in_other_unit(*other)) {
        return Finding::new("factor", "the value is that of another unit");
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
        own if own.iter().all(|check| passes(check, 2.0 * right.value - rejected)) => {
            "the check is a limit: it accepts a value that is as wrong on the other side"
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
