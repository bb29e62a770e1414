//! The quantity of a question that the swept key determines, such as the packing fraction where the radius is swept.

use super::AnswerSource;
use super::question::is_named_in_question;
use crate::metric::{Metric, MetricScope};
use crate::statistics::MissingError;
use kinetoscope_manifest::Coordinate;
use std::sync::Arc;

/// Digits of a value in a sentence, less one.
const DECIMALS: usize = 3;

/// Whether the manifest alone determines the value of a run.
pub(super) fn is_set_by_manifest(metric: &Metric) -> bool {
    metric.estimate.missing_error == Some(MissingError::SetByManifest)
}

/// The metrics with that quantity as their coordinate in place of the swept key; `None` if the question names none that the manifest sets, or if two
/// points have the same value of it.
pub(super) fn in_asked_variable(
    metrics: &[&Metric],
    source: &AnswerSource<'_>,
) -> Option<Vec<Metric>> {
    let is_set = |metric: &&Metric| {
        // The words for a key would have no unit.
        let is_pure = ["", "1"].contains(&metric.unit());
        is_pure
            && is_set_by_manifest(metric)
            && is_named_in_question(source, metric.definition.label)
    };
    let name = source.metrics.iter().find(is_set)?.name();
    let value_at = |coordinates: &[Coordinate]| {
        let is_there = |it: &&Metric| it.name() == name && it.coordinates() == coordinates;
        source.metrics.iter().find(is_there).map(Metric::value).filter(|value| value.is_finite())
    };
    let renamed = metrics.iter().map(|metric| {
        let [_] = metric.coordinates() else { return None };
        let value: f64 = format!("{:.DECIMALS$e}", value_at(metric.coordinates())?).parse().ok()?;
        let coordinates = vec![Coordinate { key: name.to_owned(), value: value.to_string() }];
        let mut renamed = (*metric).clone();
        match &mut renamed.scope {
            MetricScope::Run(scope) => Arc::make_mut(scope).coordinates = coordinates,
            MetricScope::Sweep(scope) => scope.coordinates = coordinates,
        }
        Some(renamed)
    });
    let renamed: Vec<Metric> = renamed.collect::<Option<_>>()?;
    let is_repeated = |(index, metric): (usize, &Metric)| {
        renamed[..index].iter().any(|other| other.coordinates() == metric.coordinates())
    };
    let is_other = metrics.first().is_some_and(|metric| metric.name() != name);
    (is_other && !renamed.iter().enumerate().any(is_repeated)).then_some(renamed)
}
