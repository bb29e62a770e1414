//! `answer`: the sentence that answers the question of an experiment, with numbers from metrics.

use crate::checks::{CheckedManifest, names};
use crate::diagnostics::{Errors, nearest};
use crate::sentence::{Fault, LONGEST_SENTENCE, fault_in, report};
use crate::sweep::{Axis, Coordinate};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, quoted, refuse_type};
use serde_json::{Value as Json, json};
use std::ops::Range;

/// The keys along which the analysis fits a metric of a sweep; empty for a metric of runs.
pub type FittedAlong = fn(metric: &str) -> Vec<&'static str>;

/// The unit of a metric, "1" for a pure number; `None` for an unknown metric.
pub type UnitOf = fn(metric: &str) -> Option<&'static str>;

/// A text with references to metrics in braces, such as `The heap has {bed.surface_angle @ friction = 0.5}.`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnswerTemplate {
    text: String,
    parts: Vec<AnswerPart>,
}

/// A part of an answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AnswerPart {
    /// Words.
    Text(String),
    /// A number.
    Metric(MetricReference),
}

/// A metric at one point of the sweep: `{METRIC}` or `{METRIC @ KEY = VALUE, KEY = VALUE}`. The words `theory`, `size`, `in percent`
/// and `to N digits` after the metric set the form of the number. A value with a comma or a brace is written in double quotes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MetricReference {
    /// Name of the metric.
    pub metric: String,
    /// Whether the number is the theoretical value.
    pub is_theory: bool,
    /// Whether the number is shown without its sign.
    pub is_size: bool,
    /// Whether the number is shown in percent.
    pub is_in_percent: bool,
    /// Number of significant digits; `None` for those that the standard error decides, or for the default.
    pub digits: Option<u8>,
    /// The point of the sweep: pairs of a key, or its last part, and its value.
    pub at: Vec<(String, String)>,
    /// Bytes of the text that the reference occupies.
    place: Range<usize>,
}

/// Maximum number of significant digits.
const MOST_DIGITS: u8 = 12;

impl AnswerTemplate {
    /// The words and numbers in order.
    #[must_use]
    pub fn parts(&self) -> &[AnswerPart] {
        &self.parts
    }

    fn parse(text: &str) -> Result<Self, Fault> {
        if let Some(fault) = fault_in("answer", text) {
            return Err(fault);
        }
        let mut parts = Vec::new();
        let mut words = String::new();
        let mut at = 0;
        while let Some(found) = text[at..].find(['{', '}']) {
            words.push_str(&text[at..at + found]);
            at += found;
            let brace = &text[at..=at];
            if text[at + 1..].starts_with(brace) {
                words.push_str(brace);
                at += 2;
            } else if brace == "}" {
                let label = "write `}}` for a brace of the text".to_owned();
                return Err((at..at + 1, "this brace closes nothing".to_owned(), label));
            } else {
                let end = at
                    + 1
                    + closing_brace(&text[at + 1..]).ok_or_else(|| {
                        let label = "needs `}`; write `{{` for a brace of the text".to_owned();
                        (at..text.len(), "this brace is not closed".to_owned(), label)
                    })?;
                if !words.is_empty() {
                    parts.push(AnswerPart::Text(std::mem::take(&mut words)));
                }
                parts.push(AnswerPart::Metric(reference(&text[at + 1..end], at..end + 1)?));
                at = end + 1;
            }
        }
        words.push_str(&text[at..]);
        if !words.is_empty() {
            parts.push(AnswerPart::Text(words));
        }
        Ok(Self { text: text.to_owned(), parts })
    }

    /// Compares the references with the metrics and the sweep of their manifest. `node` is the value of the key.
    pub(crate) fn check(
        &self,
        node: &Node,
        manifest: CheckedManifest<'_>,
        (fitted_along, unit_of): (Option<FittedAlong>, Option<UnitOf>),
        errors: &mut Errors,
    ) {
        for part in &self.parts {
            let AnswerPart::Metric(reference) = part else { continue };
            let form = reference.check_form(unit_of);
            if let Err((title, label)) = form.and(reference.check(manifest, fitted_along)) {
                report(node, &self.text, (reference.place.clone(), title, label), errors);
            }
        }
    }
}

/// The brace that ends a reference, which is not in quotes.
fn closing_brace(text: &str) -> Option<usize> {
    let mut is_quoted = false;
    text.char_indices().find_map(|(at, character)| {
        is_quoted ^= character == '"';
        (character == '}' && !is_quoted).then_some(at)
    })
}

/// Reads the text between two braces.
fn reference(text: &str, place: Range<usize>) -> Result<MetricReference, Fault> {
    let fault = |title: &str, label: &str| (place.clone(), title.to_owned(), label.to_owned());
    let (value, point) = text.split_once('@').map_or((text, None), |(value, at)| (value, Some(at)));
    let mut words = value.split_whitespace();
    let metric = words.next().ok_or_else(|| {
        fault("no metric between the braces", "write `{METRIC}` or `{METRIC @ KEY = VALUE}`")
    })?;
    let mut reference = MetricReference {
        metric: metric.to_owned(),
        is_theory: false,
        is_size: false,
        is_in_percent: false,
        digits: None,
        at: Vec::new(),
        place: place.clone(),
    };
    let formats: Vec<&str> = words.collect();
    let mut rest = formats.as_slice();
    while !rest.is_empty() {
        rest = match rest {
            ["theory", rest @ ..] => {
                reference.is_theory = true;
                rest
            }
            ["size", rest @ ..] => {
                reference.is_size = true;
                rest
            }
            ["in", "percent", rest @ ..] => {
                reference.is_in_percent = true;
                rest
            }
            ["to", digits, "digits", rest @ ..] => {
                let digits = digits.parse().ok();
                let digits = digits.filter(|digits| (1..=MOST_DIGITS).contains(digits));
                reference.digits = Some(digits.ok_or_else(|| {
                    let label = format!("must be a whole number from 1 to {MOST_DIGITS}");
                    fault("this is not a number of digits", &label)
                })?);
                rest
            }
            _ => {
                let title = format!("`{}` is not a form of a number", rest.join(" "));
                let label = "must be `theory`, `size`, `in percent` or `to N digits`";
                return Err(fault(&title, label));
            }
        };
    }
    for condition in point.map_or_else(Vec::new, conditions) {
        let pair = condition.split_once('=').map(|(key, value)| (unquoted(key), unquoted(value)));
        let pair = pair.filter(|(key, value)| !key.is_empty() && !value.is_empty());
        reference.at.push(pair.ok_or_else(|| {
            fault("this is not a point of the sweep", "write `@ KEY = VALUE, KEY = VALUE`")
        })?);
    }
    Ok(reference)
}

/// Splits `KEY = VALUE, KEY = VALUE` at the commas that are not in quotes.
fn conditions(text: &str) -> Vec<&str> {
    let mut is_quoted = false;
    let split = text.split(move |character| {
        is_quoted ^= character == '"';
        character == ',' && !is_quoted
    });
    split.collect()
}

fn unquoted(text: &str) -> String {
    let text = text.trim();
    let inner = text.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
    inner.unwrap_or(text).to_owned()
}

/// Whether a value of the sweep is the written one: the same text, or the same number.
fn is_value(written: &str, value: &str) -> bool {
    let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite());
    written == value || number(written).is_some_and(|written| number(value) == Some(written))
}

impl MetricReference {
    /// Whether the reference is to a run, or to a mean or a fit over runs, with these coordinates.
    #[must_use]
    pub fn selects(&self, coordinates: &[Coordinate]) -> bool {
        self.at.iter().all(|(key, value)| {
            let mut coordinates = coordinates.iter();
            coordinates.any(|it| names(key, &it.key) && is_value(value, &it.value))
        })
    }

    /// Whether the metric can have the form of the number.
    ///
    /// # Errors
    /// What is wrong, and what to do.
    fn check_form(&self, unit_of: Option<UnitOf>) -> Result<(), (String, String)> {
        let unit = unit_of.filter(|_| self.is_in_percent).and_then(|of| of(&self.metric));
        let Some(unit) = unit.filter(|unit| !matches!(*unit, "" | "1")) else { return Ok(()) };
        let title = format!("`{}` is in {unit}, not a pure number", self.metric);
        Err((title, "leave out `in percent`".to_owned()))
    }

    /// Whether the metric is known and has one value here.
    ///
    /// # Errors
    /// What is wrong, and what to do.
    fn check(
        &self,
        manifest: CheckedManifest<'_>,
        fitted_along: Option<FittedAlong>,
    ) -> Result<(), (String, String)> {
        let metric = &self.metric;
        if let Some(known) = manifest.metrics.filter(|known| !known.contains(&metric.as_str())) {
            let label = match nearest(metric, known.iter().copied()) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => "`kinetoscope analyze --list-metrics` lists all metrics".to_owned(),
            };
            return Err((format!("`{metric}` is not a metric"), label));
        }
        let Some(axes) = manifest.axes else { return Ok(()) };
        for (key, value) in &self.at {
            check_condition(key, value, axes)?;
        }
        // Without the fits, it is unknown which keys a metric of a sweep has a value for.
        let Some(fitted_along) = fitted_along else { return Ok(()) };
        let along = fitted_along(metric);
        let is_along =
            |axis: &&Axis| matches!(axis.keys.as_slice(), [key] if along.contains(&&**key));
        let fit = axes.iter().find(is_along);
        if let (None, [key, ..]) = (fit, along.as_slice()) {
            let title = format!("`{metric}` is fitted along `{key}`, which is not swept");
            return Err((title, "take a metric of a run".to_owned()));
        }
        if let Some(fit) = fit.filter(|fit| self.at.iter().any(|(key, _)| names(key, &fit.keys[0])))
        {
            let title = format!("`{metric}` is one number for all values of `{}`", fit.keys[0]);
            return Err((title, "leave out the key".to_owned()));
        }
        let others = axes.iter().filter(|axis| fit.is_none_or(|fit| !std::ptr::eq(fit, *axis)));
        let mut open = Vec::new();
        for axis in others {
            match axis.values.iter().filter(|values| self.is_on(axis, values)).count() {
                0 => {
                    let title = "no point of the sweep has all these values".to_owned();
                    return Err((title, format!("on the axis of `{}`", axis.keys[0])));
                }
                1 => {}
                _ => open.push(axis),
            }
        }
        let Some(first) = open.first() else { return Ok(()) };
        let keys: Vec<&str> = open.iter().map(|axis| axis.keys[0].as_str()).collect();
        let title = format!("`{metric}` has one value for each value of {}", keys.join(" and "));
        let example = format!("{} = {}", last_part(&first.keys[0]), first.values[0][0]);
        Err((title, format!("name the point, such as `@ {example}`")))
    }

    /// Whether a point of an axis has the written values.
    fn is_on(&self, axis: &Axis, values: &[String]) -> bool {
        self.at.iter().all(|(key, written)| {
            let column = axis.keys.iter().position(|full| names(key, full));
            column.is_none_or(|column| is_value(written, &values[column]))
        })
    }
}

/// Whether a key is swept, and has a value.
///
/// # Errors
/// What is wrong, and what to do.
fn check_condition(key: &str, value: &str, axes: &[Axis]) -> Result<(), (String, String)> {
    let keys = || axes.iter().flat_map(|axis| &axis.keys).map(String::as_str);
    let found = axes.iter().find_map(|axis| {
        axis.keys.iter().position(|full| names(key, full)).map(|column| (axis, column))
    });
    let Some((axis, column)) = found else {
        let label = match nearest(key, keys().map(last_part).chain(keys())) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if axes.is_empty() => "the manifest has no sweep".to_owned(),
            None => format!("must be one of {}", keys().collect::<Vec<_>>().join(", ")),
        };
        return Err((format!("`{key}` is not swept"), label));
    };
    let mut values = axis.values.iter().map(|values| values[column].as_str());
    if !values.clone().any(|known| is_value(value, known)) {
        let known: Vec<&str> = values.by_ref().take(20).collect();
        let title = format!("the sweep has no point `{key}` = {value}");
        return Err((title, format!("values: {}", known.join(", "))));
    }
    Ok(())
}

fn last_part(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

impl TomlValue for AnswerTemplate {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        let Value::Text(text) = &node.value else {
            return refuse_type(node, name, "a string", errors);
        };
        match Self::parse(text) {
            Ok(answer) => Some(answer),
            Err(fault) => {
                report(node, text, fault, errors);
                None
            }
        }
    }

    fn write(&self) -> String {
        quoted(&self.text)
    }

    fn schema() -> Json {
        json!({ "type": "string", "minLength": 1, "maxLength": LONGEST_SENTENCE })
    }
}
