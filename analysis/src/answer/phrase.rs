//! How a sentence about one number begins: a change, a ratio to the start, or "The … is".

use super::AnswerSource;
use super::place::place_words;
use super::question::asks_for_pace;
use crate::metric::{Metric, MetricScope};
use crate::number_text::{significant, six_digits};
use crate::run::RunAnalysis;
use kinetoscope_manifest::model::{ModelConfig, RunLength};

/// Digits of the time from the start to the end.
const DIGITS: u8 = 4;

/// The words around a number.
#[derive(Debug, PartialEq)]
pub(super) struct Phrase {
    /// The words before the number.
    pub(super) before: String,
    /// Whether the number is without its sign, which the words state.
    pub(super) is_size: bool,
    /// The words after the number.
    pub(super) after: String,
}

/// The words for a metric with this label. `relation` follows the number; `span` is the part of the run from its start to its end, such as "1 s".
pub(super) fn phrase(metric: &Metric, label: &str, relation: &str, span: Option<&str>) -> Phrase {
    let place = place_words(metric.coordinates());
    let value = metric.value();
    if let Some((quantity, per, verb)) = change(label, value) {
        // A relation compares numbers with their signs.
        if value > 0.0 || relation.is_empty() && value < 0.0 {
            let before = format!("The {quantity}{place} {verb} by ");
            let within = span.filter(|_| per.is_empty()).map(|span| format!(" in {span}"));
            let after = format!("{per}{}", within.unwrap_or_default());
            return Phrase { before, is_size: true, after };
        }
    }
    if let Some((whole, cause)) = part(label) {
        let before = format!("{cause}{place} takes ");
        return Phrase { before, is_size: false, after: format!(" of the {whole}") };
    }
    let label = at_end(label, span);
    let ratio = label.strip_prefix("ratio of the ");
    if let Some(quantity) = ratio.and_then(|it| it.strip_suffix(" to that at the start")) {
        let before = format!("The {quantity}{place} is ");
        return Phrase { before, is_size: false, after: " times that at the start".to_owned() };
    }
    Phrase { before: format!("The {label}{place} is "), is_size: false, after: String::new() }
}

/// The whole and, capitalized, the cause of a fraction, such as "dissipated energy" and "Friction".
pub(super) fn part(label: &str) -> Option<(&str, String)> {
    let (whole, cause) = label.strip_prefix("fraction of the ")?.split_once(" that is due to ")?;
    let mut letters = cause.chars();
    let first = letters.next()?.to_uppercase();
    Some((whole, format!("{first}{}", letters.as_str())))
}

/// A label that names the end of the run by its time, and of a change the time that it took, if it is known.
pub(super) fn at_end(label: &str, span: Option<&str>) -> String {
    let is_change = change(label, 0.0).is_some_and(|(_, per, _)| per.is_empty())
        || label.starts_with("largest relative error");
    match span {
        Some(span) if is_change => format!("{label} in {span}"),
        Some(span) => label.replace("at the end", &format!("after {span}")),
        None => label.to_owned(),
    }
}

/// The quantity that changes, what its change is referred to, such as " per revolution", and the verb.
fn change(label: &str, value: f64) -> Option<(&str, &str, &'static str)> {
    let (quantity, verbs) = match label.strip_prefix("relative change of the ") {
        Some(quantity) => (quantity, ["falls", "rises"]),
        None => (label.strip_prefix("relative growth of the ")?, ["shrinks", "grows"]),
    };
    let (quantity, per) = quantity.split_at(quantity.find(" per ").unwrap_or(quantity.len()));
    Some((quantity, per, verbs[usize::from(value > 0.0)]))
}

/// From the start to the end of the runs of all metrics, in words; `None` if they differ.
pub(super) fn common_span(metrics: &[&Metric], source: &AnswerSource<'_>) -> Option<String> {
    let mut spans = metrics.iter().map(|metric| span(metric, source));
    let first = spans.next()??;
    spans.all(|other| other.as_ref() == Some(&first)).then_some(first)
}

/// The same of a single metric.
pub(super) fn span(metric: &Metric, source: &AnswerSource<'_>) -> Option<String> {
    let is_of_metric = |run: &&RunAnalysis| match &metric.scope {
        MetricScope::Run(scope) => scope.file == run.file,
        MetricScope::Sweep(_) => metric.coordinates() == run.coordinates,
    };
    let is_with_time = asks_for_pace(source);
    let mut spans = source.runs.iter().filter(is_of_metric).map(|run| span_of(run, is_with_time));
    let first = spans.next()?;
    spans.all(|other| other == first).then_some(first)
}

/// A number of events with the time that they take, if that is asked for.
fn span_of(run: &RunAnalysis, is_with_time: bool) -> String {
    if let Some(events) = events_per_disc(run) {
        let time = format!(" ({} units of time)", significant(run.end_time, DIGITS));
        return format!("{events} events per disc{}", if is_with_time { &time } else { "" });
    }
    match (run.time_unit.as_str(), run.end_time) {
        ("d", end) => format!("{} days", six_digits(end)),
        (unit, end) => format!("{} {unit}", significant(end, DIGITS)).trim_end().to_owned(),
    }
}

/// The length of a run in events; `None` for another one.
pub(super) fn events_per_disc(run: &RunAnalysis) -> Option<u32> {
    match run.model() {
        ModelConfig::Packing(config) => match config.length {
            RunLength::EventsPerDisc(events) => Some(events.get()),
            _ => None,
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{at_end, change, part};

    /// Control: a change that is referred to something else, and a label without time.
    #[test]
    fn changes_and_ends_have_their_time() {
        for (label, expected) in [
            ("relative growth of the axis", "relative growth of the axis in 365 days"),
            ("error at the end", "error after 365 days"),
            ("relative change of the energy per revolution", ""),
            ("pressure on the wall", ""),
        ] {
            let expected = if expected.is_empty() { label } else { expected };
            assert_eq!(at_end(label, Some("365 days")), expected);
            assert_eq!(at_end(label, None), label);
        }
    }

    /// Control: a fraction without a cause.
    #[test]
    fn causes_of_fractions_are_subjects() {
        let label = "fraction of the dissipated energy that is due to friction";
        assert_eq!(part(label), Some(("dissipated energy", "Friction".to_owned())));
        assert_eq!(part("fraction of the particles within half of the radius"), None);
    }

    #[test]
    fn changes_have_a_verb_of_their_sign() {
        let energy = "relative change of the energy per revolution";
        assert_eq!(change(energy, 0.1), Some(("energy", " per revolution", "rises")));
        assert_eq!(change("relative growth of the axis", -0.1), Some(("axis", "", "shrinks")));
        assert_eq!(change("energy", 0.1), None);
    }
}
