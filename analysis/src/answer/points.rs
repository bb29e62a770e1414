//! Sentences about the values of one metric at several points of a sweep: how they depend on the swept key, and how far they are from
//! theory at most.

use super::dependence::{Dependence, dependence};
use super::number::{common_texts, conserved, literal_errors, number_with, size_text};
use super::phrase::{at_end, common_span, part};
use super::place::{is_number_of_things, key_words, place_words};
use super::variable::in_asked_variable;
use super::{AnswerNumber, AnswerPart, AnswerSource};
use crate::metric::{Deviation, Metric, MetricScope};
use crate::number_text::significant;
use crate::statistics::students_t::two_sided_probability;
use kinetoscope_manifest::{Coordinate, unit_of_key};

/// Maximum number of values that a sentence lists with their places.
const MOST_LISTED: usize = 4;

/// The values of several points with their places, or the first and the last of those that follow a simple dependence, or the least and
/// the greatest of many, and how far from theory they are at most.
pub(super) fn several(
    is_passed: Option<bool>,
    metrics: &[&Metric],
    has_places: bool,
    source: &AnswerSource<'_>,
) -> Vec<AnswerPart> {
    let span = common_span(metrics, source);
    let renamed = in_asked_variable(metrics, source);
    let renamed: Vec<&Metric> = renamed.iter().flatten().collect();
    let metrics = if renamed.is_empty() { metrics } else { &renamed };
    let by_value = |one: &&&Metric, other: &&&Metric| one.value().total_cmp(&other.value());
    let extremes = metrics.iter().min_by(by_value).zip(metrics.iter().max_by(by_value));
    let Some((least, greatest)) = extremes else { return Vec::new() };
    let everywhere = everywhere(metrics.len());
    let size = |metric: &Metric| metric.value().abs();
    let worst = if size(least) > size(greatest) { least } else { greatest };
    if let Some(conserved) = conserved(worst).filter(|_| !has_places) {
        return vec![
            AnswerPart::words(format!("The {conserved} is conserved to ")),
            AnswerPart::Number(AnswerNumber {
                text: size_text(worst),
                ..number_with(worst, String::new(), is_passed)
            }),
            AnswerPart::words(format!("{everywhere}.")),
        ];
    }
    let label = at_end(least.definition.label, span.as_deref());
    let is_loss = metrics.iter().all(is_loss);
    let label = if is_loss { loss_words(&label) } else { label };
    let sign = if is_loss { -1.0 } else { 1.0 };
    let relation = if has_places { String::new() } else { common_relation(metrics) };
    let ends = common_texts(&[least, greatest]);
    if ends[0] == ends[1] && !has_places {
        let number = sizes(&[least]).concat();
        let number = AnswerPart::Number(number_with(least, number, is_passed));
        let end = AnswerPart::words(format!("{everywhere}{relation}."));
        return vec![AnswerPart::words(format!("The {label} is ")), number, end];
    }
    let dependence =
        if has_places { Dependence::None } else { dependence(metrics, sign, swept_words) };
    let mut parts = Vec::new();
    let after = match dependence {
        Dependence::OfEnds { verb, first, last } => {
            parts.push(AnswerPart::words(format!("The {label} {verb}, ")));
            parts.extend(from_to(metrics[first], metrics[last], is_passed));
            String::new()
        }
        other => {
            let begin = match part(&label) {
                Some((whole, cause)) => format!("Of the {whole}, {} takes ", cause.to_lowercase()),
                None => format!("The {label} is "),
            };
            parts.push(AnswerPart::words(begin));
            parts.extend(listed(metrics, is_passed));
            match other {
                Dependence::Remark(remark) => remark,
                Dependence::GreatestAt(index) => {
                    format!(", greatest{}", place_words(metrics[index].coordinates()))
                }
                Dependence::LeastAt(index) => {
                    format!(", least{}", place_words(metrics[index].coordinates()))
                }
                _ => String::new(),
            }
        }
    };
    parts.push(AnswerPart::words(format!("{after}{relation}.")));
    parts
}

/// The beginning of the label of a change.
const CHANGE: &str = "relative change of the ";

/// Whether a value is a loss: if all are, they are given without their sign.
fn is_loss(metric: &&Metric) -> bool {
    metric.definition.label.starts_with(CHANGE) && metric.value() < 0.0
}

/// The label of a change whose values are losses.
fn loss_words(label: &str) -> String {
    label.replacen(CHANGE, "relative loss of ", 1)
}

/// The values of several points, of losses without their sign.
fn sizes(metrics: &[&Metric]) -> Vec<String> {
    let texts = common_texts(metrics);
    match metrics.iter().all(is_loss) {
        true => texts.into_iter().map(|text| text.replacen('−', "", 1)).collect(),
        false => texts,
    }
}

fn swept_words(coordinate: &Coordinate) -> String {
    let unit = unit_of_key(&coordinate.key);
    let words = key_words(&coordinate.key, unit);
    if is_number_of_things(&words, unit) { format!("number of {words}") } else { words }
}

pub(super) fn everywhere(points: usize) -> String {
    match points {
        2 => " at both points of the sweep".to_owned(),
        all => format!(" at all {all} points of the sweep"),
    }
}

/// Values with their places, or the least and the greatest of many.
pub(super) fn listed(metrics: &[&Metric], is_passed: Option<bool>) -> Vec<AnswerPart> {
    let by_value = |one: &&&Metric, other: &&&Metric| one.value().total_cmp(&other.value());
    let extremes = metrics.iter().min_by(by_value).zip(metrics.iter().max_by(by_value));
    let mut parts = Vec::new();
    if metrics.len() > MOST_LISTED {
        return extremes.map_or_else(Vec::new, |(one, other)| from_to(one, other, is_passed));
    }
    for (index, (metric, text)) in metrics.iter().zip(sizes(metrics)).enumerate() {
        let separator = match metrics.len() - index {
            1 => "",
            2 => " and ",
            _ => ", ",
        };
        parts.push(AnswerPart::Number(number_with(metric, text, is_passed)));
        parts.push(AnswerPart::words(place_words(metric.coordinates()) + separator));
    }
    parts
}

fn from_to(one: &Metric, other: &Metric, is_passed: Option<bool>) -> Vec<AnswerPart> {
    let mut parts = Vec::new();
    let texts = sizes(&[one, other]);
    for ((metric, text), word) in [one, other].into_iter().zip(texts).zip(["from ", " to "]) {
        parts.push(AnswerPart::words(word));
        parts.push(AnswerPart::Number(number_with(metric, text, is_passed)));
        parts.push(AnswerPart::words(place_words(metric.coordinates())));
    }
    parts
}

/// Probability of the largest deviation of several points below which it is called unlikely.
const UNLIKELY: f64 = 0.01;
/// Probability above which the points are called close to theory.
const LIKELY: f64 = 0.05;

/// How far from theory several points are at most.
fn common_relation(metrics: &[&Metric]) -> String {
    let law = common_law(metrics);
    let violation = |metric: &&Metric| metric.theory?.violation;
    if let Some(violation) = metrics.iter().find_map(violation) {
        let law = if law == THEORY { "its law" } else { law };
        return format!(", outside the range of {law}: {violation}");
    }
    let sigma = |metric: &&Metric| match metric.deviation() {
        Some(Deviation::StandardErrors(sigma)) => Some(literal_errors(sigma, metric).abs()),
        Some(Deviation::Rounding) => Some(0.0),
        _ => None,
    };
    let sigmas: Option<Vec<f64>> = metrics.iter().map(sigma).collect();
    if let Some(worst) = sigmas.and_then(|all| all.into_iter().reduce(f64::max)) {
        return in_standard_errors(worst, metrics.len(), law) + &chance_words(worst, metrics);
    }
    let is_inside =
        |metric: &&Metric| matches!(metric.deviation(), Some(Deviation::Bound { is_inside: true }));
    let all_inside = metrics.iter().all(is_inside);
    let law = if law == THEORY { "the law" } else { law };
    if all_inside { format!(", within the accuracy of {law}") } else { String::new() }
}

/// The largest of the deviations of some points from a law, in words that state whether it is unlikely.
fn in_standard_errors(worst: f64, points: usize, law: &str) -> String {
    if worst == 0.0 {
        return format!(", equal to {law}");
    }
    let number = significant(worst, 2);
    match probability(worst, points) {
        _ if worst <= 1.0 => format!(", within one standard error of {law}"),
        probability if probability >= LIKELY => {
            format!(", within {number} standard errors of {law}")
        }
        probability if probability >= UNLIKELY => {
            format!(", up to {number} standard errors from {law}")
        }
        _ => format!(", but up to {number} standard errors from {law}"),
    }
}

/// Probability that the largest of the deviations of some points is as large.
fn probability(worst: f64, points: usize) -> f64 {
    1.0 - libm::pow(1.0 - two_sided_probability(worst, None), points as f64)
}

/// Of a largest deviation that is unlikely by chance, how unlikely, and what it is or what would show that; empty for others.
pub(super) fn chance_words(worst: f64, metrics: &[&Metric]) -> String {
    let probability = probability(worst, metrics.len());
    if probability >= UNLIKELY {
        return String::new();
    }
    // A probability below the least number is one of 1 in infinity.
    let of = 1.0 / probability.max(LEAST_PROBABILITY);
    let runs = if metrics.len() == 1 { "runs" } else { "sweeps" };
    let is_of_one = |metric: &&&Metric| match &metric.scope {
        MetricScope::Run(_) => true,
        MetricScope::Sweep(scope) => scope.replicates < 2,
    };
    let rest = match metrics.iter().any(|metric| is_of_one(&metric)) {
        true => "whether it is more than chance, replicates would show",
        false => "it is not chance, but a deviation",
    };
    format!(": of {} such {runs}, 1 is as far off by chance alone; {rest}", significant(of, 1))
}

/// Least probability that is stated.
const LEAST_PROBABILITY: f64 = 1e-6;

/// What a law without a name is called.
const THEORY: &str = "theory";

/// The name of the law of all metrics.
fn common_law(metrics: &[&Metric]) -> &'static str {
    let name = |metric: &&Metric| metric.theory.and_then(|theory| theory.law?.name);
    let first = metrics.first().and_then(name);
    first.filter(|_| metrics.iter().all(|metric| name(metric) == first)).unwrap_or(THEORY)
}

#[cfg(test)]
mod tests {
    use super::in_standard_errors;

    /// Source: two-sided probabilities of the normal distribution, 0.0455 at 2 and 0.00097 at 3.3 (any table).
    #[test]
    fn unlikely_deviations_do_not_read_as_agreement() {
        let text = |worst, points| in_standard_errors(worst, points, "theory");
        assert_eq!(text(0.0, 3), ", equal to theory");
        assert_eq!(text(0.9, 3), ", within one standard error of theory");
        assert_eq!(text(2.0, 3), ", within 2 standard errors of theory");
        assert_eq!(text(2.0, 1), ", up to 2 standard errors from theory");
        assert_eq!(text(3.3, 3), ", but up to 3.3 standard errors from theory");
        // Control: among many points, a large deviation is expected.
        assert_eq!(text(3.3, 60), ", within 3.3 standard errors of theory");
    }
}
