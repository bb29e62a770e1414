//! `[[checks]]`: the values that metrics must have.

use crate::diagnostics::{Diagnostic, Diagnostics, Errors, nearest};
use crate::keys::{HasKeys as _, Reader, Writer, rules};
use crate::model::ModelConfig;
use crate::quantity::{Finite, NonNegative};
use crate::sweep::{Axis, Coordinate, VARIANT, text};
use crate::syntax::{LineCounter, parse_toml};
use crate::table::table;
use crate::tree::{Entry, Node, Table};
use crate::value::{quoted, refuse_type, tables, words};
use std::collections::HashSet;

/// The names of the metrics of a model's runs and of sweeps over them, which the analysis defines.
pub type MetricNames = fn(model: &str) -> Vec<&'static str>;

/// A condition on a metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Name of the metric, such as `pressure_vs_temperature.measured.slope`.
    pub metric: String,
    /// The points of the sweep: pairs of a key and its value, in the form of [`Coordinate`]. Empty means every point.
    pub at: Vec<(String, String)>,
    /// What the metric is compared with.
    pub bound: Bound,
    /// The result if the metric cannot be compared, because it has no standard error or no theoretical value.
    pub if_undecided: IfUndecided,
    /// The check's line in the manifest, from 1; 0 if it is not known.
    pub line: u32,
}

words! {
    /// The result of a check that cannot be evaluated.
    pub enum IfUndecided {
        /// The check fails.
        Fail = "fail",
        /// The check passes.
        Pass = "pass",
    }
}

/// What a metric is compared with. Without an expected value, this is the metric's theoretical value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// |value - expected| <= tolerance, in the metric's unit.
    Near {
        /// The value expected; `None` is the theory's.
        expected: Option<f64>,
        /// Largest deviation allowed.
        tolerance: f64,
    },
    /// |value - expected| <= relative_tolerance |expected|.
    NearRelative {
        /// The value expected; `None` is the theory's.
        expected: Option<f64>,
        /// Largest deviation allowed, as a fraction of the expected value.
        relative_tolerance: f64,
    },
    /// |value - expected| is at most this number of standard errors by Student's t, with the accuracy of the law.
    WithinStandardErrors {
        /// The value expected; `None` is the theory's.
        expected: Option<f64>,
        /// Largest deviation allowed, in standard errors.
        standard_errors: f64,
    },
    /// |value - theory| <= this many standard errors, or within rounding: the deviation as the report shows it.
    MaxDeviation {
        /// Largest deviation allowed.
        sigma: f64,
    },
    /// minimum <= value <= maximum; at least one of the two is given.
    Range {
        /// Smallest value allowed.
        minimum: Option<f64>,
        /// Largest value allowed.
        maximum: Option<f64>,
    },
}

impl Check {
    /// Whether the check applies to a run or group with these coordinates. A key may be written as its last part only.
    #[must_use]
    pub fn selects(&self, coordinates: &[Coordinate]) -> bool {
        selects(&self.at, coordinates)
    }
}

/// Whether a run or group with these coordinates is at one of the points that `where` selects.
pub(crate) fn selects(at: &[(String, String)], coordinates: &[Coordinate]) -> bool {
    at.iter().all(|(key, value)| {
        coordinates.iter().any(|place| names(key, &place.key) && place.value == *value)
    })
}

/// Whether a key, or its last part, is written so.
pub(crate) fn names(written: &str, key: &str) -> bool {
    written == key || key.rsplit('.').next() == Some(written)
}

/// Reads a file that contains only `[[checks]]`. They may name the metrics of any model, and any name without `metrics`.
///
/// # Errors
/// Everything that is wrong with it, each error with its place.
pub fn parse_checks(
    source: &str,
    origin: &str,
    metrics: Option<MetricNames>,
) -> Result<Vec<Check>, Diagnostics> {
    let mut diagnostics = Diagnostics::default();
    let (mut root, syntax) = parse_toml(source, origin, &mut diagnostics);
    if syntax.hides_tables {
        return Err(diagnostics.with(syntax.errors));
    }
    let mut errors = syntax.errors;
    let checks = root.take("checks");
    let metrics = metrics.map(|metrics| ModelConfig::NAMES.map(metrics).concat());
    let file = CheckedManifest { source, axes: None, metrics: metrics.as_deref() };
    let read =
        checks.as_ref().map_or_else(Vec::new, |checks| read(&checks.node, Some(file), &mut errors));
    let mut reader = Reader::new("", &root, &mut errors);
    reader.also_known(&["checks"]);
    reader.finish();
    if checks.is_none() && errors.is_empty() {
        errors.push(Diagnostic::new("no [[checks]] in this file"));
    }
    diagnostics.ok_or(read, errors)
}

table! {
    /// The keys of a check except the table `where`.
    pub(crate) struct CheckKeys at most one of [tolerance, relative_tolerance, standard_errors, max_deviation_sigma] {
        /// Name of the metric, as in metrics.json.
        metric: String [""] = String::new(),
        /// The value expected; by default the theory's.
        expected: Option<Finite> ["of the metric", optional],
        /// Largest deviation allowed.
        tolerance: Option<NonNegative> ["of the metric", optional],
        /// Largest deviation allowed, as a fraction of the expected value.
        relative_tolerance: Option<NonNegative> ["1", optional],
        /// Largest deviation allowed, in standard errors of the metric.
        standard_errors: Option<NonNegative> ["1", optional],
        /// Largest deviation from the theory allowed, in standard errors, as the report shows it; rounding passes.
        max_deviation_sigma: Option<NonNegative> ["1", optional],
        /// Smallest value allowed.
        minimum: Option<Finite> ["of the metric", optional],
        /// Largest value allowed.
        maximum: Option<Finite> ["of the metric", optional],
        /// Result where the metric has no standard error or no theoretical value to compare with: fail (default) or pass.
        if_undecided: Option<IfUndecided> ["", optional],
    }
}

/// The keys that bound a metric. A check has exactly one, or both `minimum` and `maximum`.
const BOUNDS: &[&str] = &[
    "tolerance",
    "relative_tolerance",
    "standard_errors",
    "max_deviation_sigma",
    "minimum",
    "maximum",
];

/// The manifest that contains checks.
#[derive(Clone, Copy)]
pub(crate) struct CheckedManifest<'a> {
    /// The text.
    pub(crate) source: &'a str,
    /// The sweep's axes, which `where` must name; `None` if they are not known.
    pub(crate) axes: Option<&'a [Axis]>,
    /// The metrics of the model, or of all models; `None` if they are not known.
    pub(crate) metrics: Option<&'a [&'static str]>,
}

impl CheckKeys {
    fn of(check: &Check) -> Self {
        let metric = check.metric.clone();
        let pass = (check.if_undecided == IfUndecided::Pass).then_some(IfUndecided::Pass);
        let keys = Self { metric, if_undecided: pass, ..Self::default() };
        let finite = |x: Option<f64>| x.and_then(Finite::new);
        match check.bound {
            Bound::Near { expected, tolerance } => {
                Self { expected: finite(expected), tolerance: NonNegative::new(tolerance), ..keys }
            }
            Bound::NearRelative { expected, relative_tolerance } => Self {
                expected: finite(expected),
                relative_tolerance: NonNegative::new(relative_tolerance),
                ..keys
            },
            Bound::WithinStandardErrors { expected, standard_errors } => Self {
                expected: finite(expected),
                standard_errors: NonNegative::new(standard_errors),
                ..keys
            },
            Bound::MaxDeviation { sigma } => {
                Self { max_deviation_sigma: NonNegative::new(sigma), ..keys }
            }
            Bound::Range { minimum, maximum } => {
                Self { minimum: finite(minimum), maximum: finite(maximum), ..keys }
            }
        }
    }

    fn bound(&self) -> Option<Bound> {
        let expected = self.expected.map(Finite::get);
        if let Some(tolerance) = self.tolerance {
            return Some(Bound::Near { expected, tolerance: tolerance.get() });
        }
        if let Some(relative) = self.relative_tolerance {
            return Some(Bound::NearRelative { expected, relative_tolerance: relative.get() });
        }
        if let Some(errors) = self.standard_errors {
            return Some(Bound::WithinStandardErrors { expected, standard_errors: errors.get() });
        }
        if let Some(sigma) = self.max_deviation_sigma {
            return Some(Bound::MaxDeviation { sigma: sigma.get() });
        }
        let (minimum, maximum) = (self.minimum.map(Finite::get), self.maximum.map(Finite::get));
        (minimum.is_some() || maximum.is_some()).then_some(Bound::Range { minimum, maximum })
    }
}

/// Reads all checks, and compares them with their manifest if they are part of one.
pub(crate) fn read(
    node: &Node,
    manifest: Option<CheckedManifest<'_>>,
    errors: &mut Errors,
) -> Vec<Check> {
    let tables = tables(node, "checks", ["tables [[checks]]", "a table"], errors);
    let mut lines = manifest.map(|manifest| LineCounter::new(manifest.source));
    let points = manifest.and_then(|manifest| manifest.axes).map(Points::new);
    let metrics = manifest.and_then(|manifest| manifest.metrics);
    let mut checks = Vec::new();
    for (element, table) in tables {
        let line = lines.as_mut().map_or(0, |lines| lines.line_of(element.span.start));
        if let Some(check) = read_one(element, table, points.as_ref(), metrics, errors) {
            checks.push(Check { line: u32::try_from(line).unwrap_or(u32::MAX), ..check });
        }
    }
    checks
}

/// The points of a sweep that `where` may name.
pub(crate) struct Points<'a> {
    axes: &'a [Axis],
    /// For each axis, the values of each of its keys.
    values: Vec<Vec<HashSet<&'a str>>>,
}

impl<'a> Points<'a> {
    pub(crate) fn new(axes: &'a [Axis]) -> Self {
        let column = |axis: &'a Axis, column: usize| {
            axis.values.iter().map(|values| values[column].as_str()).collect()
        };
        let columns = |axis: &'a Axis| (0..axis.keys.len()).map(|key| column(axis, key)).collect();
        Self { axes, values: axes.iter().map(columns).collect() }
    }

    /// The keys of each axis whose values are numbers, without axes of other values.
    pub(crate) fn numeric_keys(&self) -> Vec<Vec<&'a str>> {
        let is_number = |value: &&str| value.parse::<f64>().is_ok_and(f64::is_finite);
        let numeric = self.axes.iter().zip(&self.values).map(|(axis, columns)| {
            let keys = axis.keys.iter().zip(columns);
            let keys = keys.filter(|(key, values)| *key != VARIANT && values.iter().all(is_number));
            keys.map(|(key, _)| key.as_str()).collect::<Vec<_>>()
        });
        numeric.filter(|keys| !keys.is_empty()).collect()
    }

    /// The keys of each axis.
    pub(crate) fn axis_keys(&self) -> Vec<Vec<&'a str>> {
        self.axes.iter().map(|axis| axis.keys.iter().map(String::as_str).collect()).collect()
    }

    /// The full name of a swept key, which may be written as its last part only.
    pub(crate) fn full_name(&self, written: &str) -> Option<&'a str> {
        let mut keys = self.axes.iter().flat_map(|axis| &axis.keys);
        keys.find(|key| names(written, key)).map(String::as_str)
    }

    /// Every swept key with the numbers of its axis and of its column.
    fn keys(&self) -> impl Iterator<Item = (usize, usize, &'a String)> + Clone {
        self.axes.iter().enumerate().flat_map(|(axis, points)| {
            points.keys.iter().enumerate().map(move |(column, key)| (axis, column, key))
        })
    }
}

fn read_one(
    element: &Node,
    table: &Table,
    points: Option<&Points<'_>>,
    metrics: Option<&[&'static str]>,
    errors: &mut Errors,
) -> Option<Check> {
    let at = table
        .get("where")
        .map_or_else(Vec::new, |place| read_where("checks", place, points, errors));
    let mut reader = Reader::new("checks", table, errors);
    reader.also_known(&["where"]);
    let mut keys = CheckKeys::default();
    keys.keys(&mut reader);
    check_metric("a check", "metric", &keys.metric, metrics, element, &mut reader);
    // A misspelled bound is reported as an unknown key.
    if !BOUNDS.iter().any(|key| reader.has(key)) && !reader.has_unknown() {
        let label = "needs `tolerance`, `relative_tolerance`, `standard_errors`, \
            `max_deviation_sigma`, `minimum` or `maximum`";
        reader
            .report(Diagnostic::new("a check has nothing to compare with").at(element.span, label));
    }
    let has_any = |keys: &[&str]| keys.iter().any(|key| table.get(key).is_some());
    let is_range = has_any(&["minimum", "maximum"]);
    let is_empty =
        keys.minimum.zip(keys.maximum).is_some_and(|(minimum, maximum)| minimum > maximum);
    rules! { reader;
        has_any(&["expected"]) && has_any(&["max_deviation_sigma"]) =>
            ["expected", "max_deviation_sigma"]
            "`expected` cannot be used with `max_deviation_sigma`",
            "the deviation is that from theory; use `standard_errors` for an expected value";
        is_range && (has_any(&["expected"]) || has_any(&BOUNDS[..4])) =>
            ["expected", "tolerance", "relative_tolerance", "standard_errors", "max_deviation_sigma", "minimum", "maximum"]
            "`minimum` and `maximum` cannot be used together with `expected` or a tolerance", "write two checks";
        is_empty => ["minimum", "maximum"] "`minimum` is above `maximum`", "must be minimum <= maximum";
    }
    reader.finish();
    let if_undecided = keys.if_undecided.unwrap_or(IfUndecided::Fail);
    Some(Check { bound: keys.bound()?, metric: keys.metric, at, if_undecided, line: 0 })
}

/// Reports a table without a metric in this key, or with one that is not among those of the model.
pub(crate) fn check_metric(
    table: &str,
    key: &'static str,
    metric: &str,
    known: Option<&[&'static str]>,
    element: &Node,
    reader: &mut Reader<'_>,
) {
    let title = format!("{table} has no metric");
    if !reader.has(key) {
        // A misspelled key is reported as an unknown one.
        if reader.has_unknown() {
            return;
        }
        reader.report(Diagnostic::new(title).at(element.span, format!("needs `{key}`")));
    } else if metric.trim().is_empty() {
        reader.refuse(&[key], title, "must not be empty");
    } else if reader.is_full() && known.is_some_and(|known| !known.contains(&metric)) {
        reader.refuse(&[key], "", "");
    } else if let Some(known) = known.filter(|known| !known.contains(&metric)) {
        let label = match nearest(metric, known.iter().copied()) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "`kinetoscope analyze --list-metrics` lists all metrics".to_owned(),
        };
        reader.refuse(&[key], format!("`{metric}` is not a metric"), label);
    }
}

/// Reads the table `where` of a check or a plot.
pub(crate) fn read_where(
    table: &str,
    place: &Entry,
    points: Option<&Points<'_>>,
    errors: &mut Errors,
) -> Vec<(String, String)> {
    let Some(places) = place.node.table() else {
        let (name, expected) = (format!("{table}.where"), "a table of swept keys and values");
        return refuse_type(&place.node, &name, expected, errors).unwrap_or_default();
    };
    let entries = places.entries.iter().flat_map(|entry| entry.leaves(&entry.key, &|_, _| false));
    entries.filter_map(|(key, entry)| read_place(&key, entry, points, errors)).collect()
}

/// Reads one key of `where`.
fn read_place(
    key: &str,
    entry: &Entry,
    points: Option<&Points<'_>>,
    errors: &mut Errors,
) -> Option<(String, String)> {
    let value = text(&entry.node, 0);
    let Some(points) = points else { return Some((key.to_owned(), value)) };
    let Some((axis, column, full)) = points.keys().find(|(_, _, full)| names(key, full)) else {
        if errors.is_full() {
            errors.count();
            return None;
        }
        let label = match nearest(key, points.keys().map(|(_, _, key)| key.as_str())) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "`where` takes keys of [sweep], or `variant`".to_owned(),
        };
        errors.push(Diagnostic::new(format!("`{key}` is not swept")).at(entry.key_span, label));
        return None;
    };
    if !points.values[axis][column].contains(value.as_str()) {
        let values = points.axes[axis].values.iter();
        let known: Vec<&str> = values.map(|values| values[column].as_str()).take(20).collect();
        let title = format!("the sweep has no point `{key}` = {value}");
        errors.push(
            Diagnostic::new(title).at(entry.node.span, format!("values: {}", known.join(", "))),
        );
    }
    Some((full.clone(), value))
}

/// Writes checks in the form in which [`parse_checks`] reads them.
pub(crate) fn write(checks: &[Check], writer: &mut Writer) {
    for check in checks {
        writer.text.push_str("\n[[checks]]\n");
        CheckKeys::of(check).keys(writer);
        write_where(&check.at, writer);
    }
}

/// Writes the table `where`, unless it selects everything.
pub(crate) fn write_where(at: &[(String, String)], writer: &mut Writer) {
    if !at.is_empty() {
        let pair = |(key, value): &(String, String)| format!("{} = {}", quoted(key), quoted(value));
        let pairs: Vec<String> = at.iter().map(pair).collect();
        writer.text.push_str(&format!("where = {{ {} }}\n", pairs.join(", ")));
    }
}
