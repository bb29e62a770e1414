//! `[[baseline]]`: how much a metric may differ from that of an earlier analysis.

use crate::checks::check_metric;
use crate::diagnostics::{Diagnostic, Errors};
use crate::keys::{HasKeys as _, Reader, Writer};
use crate::quantity::NonNegative;
use crate::table::table;
use crate::tree::{Node, Table};
use crate::value::tables;

/// The tolerance of a metric in a comparison with an earlier analysis of other runs. It replaces the metric's rounding and its
/// standard error; an analysis of the same runs must give the same values.
#[derive(Clone, Debug, PartialEq)]
pub struct BaselineTolerance {
    /// Name of the metric.
    pub metric: String,
    /// Largest difference allowed, as a fraction of the earlier value.
    pub relative_tolerance: f64,
}

table! {
    /// The keys of one of `[[baseline]]`.
    pub(crate) struct BaselineKeys {
        /// Name of the metric, as in metrics.json.
        metric: String [""] = String::new(),
        /// Largest difference from the value of an earlier analysis, as a fraction of that value. It replaces the metric's
        /// rounding and its standard error.
        relative_tolerance: Option<NonNegative> ["1", optional],
    }
}

/// Reads all tolerances; `metrics` are those of the model, or `None` if they are not known.
pub(crate) fn read(
    node: &Node,
    metrics: Option<&[&'static str]>,
    errors: &mut Errors,
) -> Vec<BaselineTolerance> {
    let tables = tables(node, "baseline", ["tables [[baseline]]", "a table"], errors);
    let mut found: Vec<BaselineTolerance> = Vec::new();
    for (element, table) in tables {
        let Some(tolerance) = read_one(element, table, metrics, errors) else { continue };
        if found.iter().any(|other| other.metric == tolerance.metric) {
            let title = format!("`{}` has two tables [[baseline]]", tolerance.metric);
            errors.push(Diagnostic::new(title).at(element.span, "one tolerance for each metric"));
        }
        found.push(tolerance);
    }
    found
}

fn read_one(
    element: &Node,
    table: &Table,
    metrics: Option<&[&'static str]>,
    errors: &mut Errors,
) -> Option<BaselineTolerance> {
    let mut reader = Reader::new("baseline", table, errors);
    let mut keys = BaselineKeys::default();
    keys.keys(&mut reader);
    check_metric("a table [[baseline]]", "metric", &keys.metric, metrics, element, &mut reader);
    if !reader.has("relative_tolerance") {
        let title = "a table [[baseline]] has no tolerance";
        reader.report(Diagnostic::new(title).at(element.span, "needs `relative_tolerance`"));
    }
    reader.finish();
    let relative_tolerance = keys.relative_tolerance?.get();
    Some(BaselineTolerance { metric: keys.metric, relative_tolerance })
}

/// Writes tolerances in the form in which they are read.
pub(crate) fn write(tolerances: &[BaselineTolerance], writer: &mut Writer) {
    for BaselineTolerance { metric, relative_tolerance } in tolerances {
        writer.text.push_str("\n[[baseline]]\n");
        let relative_tolerance = NonNegative::new(*relative_tolerance);
        BaselineKeys { metric: metric.clone(), relative_tolerance }.keys(writer);
    }
}
