//! What the question of an experiment asks for and its runs do not show. A sentence that could be false is left out.

use super::AnswerSource;
use super::place::{is_number_of_things, key_words, place_words};
use super::question::{is_named_in_question, shared_words, words_of};
use crate::input::coordinates::last_part;
use crate::metric::Metric;
use crate::models::{label_of, metrics_of};
use crate::number_text::{short_number, significant};
use crate::run::RunAnalysis;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::{Coordinate, unit_of_key};

/// Words before a cause, and those after it; without any, it ends with the clause.
const CAUSES: [(&str, &[&str]); 12] = [
    ("what does", EFFECTS),
    ("what do", EFFECTS),
    ("depend on", &[]),
    ("depends on", &[]),
    ("effect of", &["on"]),
    ("influence of", &["on"]),
    ("vary with", &[]),
    ("varies with", &[]),
    ("change with", &[]),
    ("changes with", &[]),
    ("how does", &["affect", "influence"]),
    ("how do", &["affect", "influence"]),
];
const EFFECTS: &[&str] = &["change", "do", "affect", "influence", "alter"];
/// Words after which there are conditions, which are no cause.
const CONDITIONS: [&str; 8] = ["at", "in", "and", "or", "for", "if", "when", "while"];

/// Keys whose names also mean a place or a time in a run, which one run shows.
const WITHIN_A_RUN: [&str; 3] = ["height", "width", "duration"];

/// Words of a question that mean a key of another name.
const SYNONYMS: [(&str, &str); 2] =
    [("method", "integrator"), ("time step", "steps per wall contact")];

/// What the runs do not show of the question, although the quantities of the answer may.
pub(super) fn remark(source: &AnswerSource<'_>, answered: &[&str]) -> Option<String> {
    let is_unasked = answered.iter().all(|name| shared_words(source, name) == 0);
    let missing = || missing_quantity(source).filter(|_| is_unasked);
    without_comparison(source).or_else(|| other_value(source)).or_else(missing)
}

/// Whether the question has no word of the names of the quantities in the answer.
pub(super) fn is_other_subject(source: &AnswerSource<'_>, answered: &[&str]) -> bool {
    let question = source.record.map_or("", |record| &record.question).to_lowercase();
    let shares = |name: &&str| {
        let label = label_of(name).unwrap_or_default();
        let is_in_both = |word: &&str| question.contains(word) && label.contains(word);
        shared_words(source, name) > 0 || ["error", "change"].iter().any(is_in_both)
    };
    !question.is_empty() && !answered.iter().any(shares)
}

/// What no key sets: a gas of any temperature has fast and slow particles.
const SPEED: &str = "speed";
/// Particles of a kind that a question compares with others, and the words of the key by which they differ.
const KINDS: [(&str, &str); 12] = [
    ("fast", SPEED),
    ("slow", SPEED),
    ("hot", "temperature"),
    ("cold", "temperature"),
    ("heav", "mass"),
    ("light", "mass"),
    ("bounc", "restitution"),
    ("elastic", "restitution"),
    ("rough", "friction"),
    ("large", "radius"),
    ("big", "radius"),
    ("small", "radius"),
];
/// Words that compare.
const COMPARATIVES: [&str; 10] = [
    "more", "less", "fewer", "longer", "shorter", "faster", "slower", "higher", "lower", "farther",
];

/// The kind of particles that a question in lower case compares with others, such as "fast particles", and the words of a key.
pub(super) fn compared_kind(question: &str) -> Option<(String, &'static str)> {
    let words: Vec<&str> = words_of(question).filter(|word| !word.is_empty()).collect();
    words.windows(2).find_map(|pair| {
        let things = ["particles", "discs", "gas", "bodies", "planets", "molecules", "atoms"];
        let kind = KINDS.iter().find(|(begin, _)| pair[0].starts_with(begin))?;
        let others = words.iter().filter(|word| **word != pair[0] || word.ends_with("er"));
        let is_compared = others.into_iter().any(|word| COMPARATIVES.contains(word));
        let is_kind = is_compared && things.contains(&pair[1]);
        is_kind.then(|| (pair.join(" "), kind.1))
    })
}

/// That no run differs in what the question asks the effect of, or that one has no particles of the kinds that it compares.
fn without_comparison(source: &AnswerSource<'_>) -> Option<String> {
    let question = source.record?.question.to_lowercase();
    let kind = compared_kind(&question);
    if let Some((kind, SPEED)) = &kind {
        return Some(format!("The runs record no quantity that compares {kind} with others."));
    }
    let cause = kind.as_ref().map(|kind| kind.1.to_owned()).or_else(|| cause(&question))?;
    let is_single = source.runs.len() == 1;
    if let Some(fraction) = packing_fraction(source).filter(|_| is_single && cause == PACKING) {
        let fraction = significant(fraction, 3);
        return Some(format!(
            "One run, with a packing fraction of {fraction}, does not show what the packing fraction changes: sweep `discs` to compare."
        ));
    }
    let mut settings = settings(source.runs.first()?).into_iter();
    let setting = settings.find(|it| is_named(it, &cause) && is_common(it, source))?;
    let (words, is_number) = name_of(&setting);
    let name = if is_number { format!("number of {words}") } else { words };
    let is_list = setting.value.starts_with('[');
    let place = if is_list { String::new() } else { place_words(std::slice::from_ref(&setting)) };
    let key = last_part(&setting.key);
    let kind = kind.filter(|_| is_single);
    if let Some((kind, _)) = kind {
        return Some(format!(
            "One run{place} does not compare {kind} with others: sweep `{key}` to compare."
        ));
    }
    Some(match is_single {
        true => format!(
            "One run{place} does not show what the {name} changes: sweep `{key}` to compare."
        ),
        false => format!("The runs do not differ in the {name}: sweep `{key}` to compare."),
    })
}

/// The value of the runs where the question names another one.
fn other_value(source: &AnswerSource<'_>) -> Option<String> {
    let question = source.record?.question.to_lowercase();
    let runs = if source.runs.len() == 1 { "The run has" } else { "The runs have" };
    let of_keys = settings(source.runs.first()?).into_iter().find_map(|setting| {
        let value: f64 = setting.value.parse().ok()?;
        let (words, is_number) = name_of(&setting);
        let asked = stated_value(&question, &words, unit_of_key(&setting.key), is_number)?;
        let is_other = differs(asked, value) && is_common(&setting, source);
        let key = last_part(&setting.key).to_owned();
        let place = place_words(&[setting]);
        let place = place.trim_start_matches(" at ").trim_start_matches(" with ");
        let asked = short_number(asked);
        is_other.then(|| format!("{runs} {place}, not {asked}: set `{key}`."))
    });
    of_keys.or_else(|| {
        let asked = stated_value(&question, PACKING, "1", false)?;
        let value = packing_fraction(source).filter(|value| differs(asked, *value))?;
        let remedy = radius_of(asked / value, source).unwrap_or_default();
        let [value, asked] = [significant(value, 3), short_number(asked)];
        Some(format!("{runs} a packing fraction of {value}, not {asked}{remedy}."))
    })
}

/// The radius at which the packing fraction is this many times as large: it is proportional to its square.
fn radius_of(ratio: f64, source: &AnswerSource<'_>) -> Option<String> {
    let is_radius = |setting: &Coordinate| name_of(setting).0 == "radius";
    let setting = settings(source.runs.first()?).into_iter().find(is_radius)?;
    let radius = setting.value.parse::<f64>().ok()? * libm::sqrt(ratio);
    let key = last_part(&setting.key);
    let has_radius = radius.is_finite() && is_common(&setting, source);
    has_radius.then(|| format!(": set `{key}` to {}", significant(radius, 4)))
}

/// The quantity that follows from several keys.
const PACKING: &str = "packing fraction";

/// The packing fraction, if there is only one.
fn packing_fraction(source: &AnswerSource<'_>) -> Option<f64> {
    let is_it = |metric: &&Metric| metric.name() == "packing_fraction" && metric.is_applicable();
    let mut all = source.metrics.iter().filter(is_it);
    let first = all.next()?;
    all.next().is_none().then(|| first.value())
}

/// Largest relative difference of a value from a rounded one that the question names.
const ROUNDING: f64 = 0.02;

fn differs(asked: f64, value: f64) -> bool {
    (asked - value).abs() > ROUNDING * value.abs()
}

/// A quantity of the model that the question names and no run has.
fn missing_quantity(source: &AnswerSource<'_>) -> Option<String> {
    let run = source.runs.first().filter(|run| run.is_complete())?;
    let all = metrics_of(run.model().name()).iter();
    let named: Vec<_> = all.filter(|known| is_named_in_question(source, known.label)).collect();
    let is_known = |name: &str| source.metrics.iter().any(|it| it.name() == name);
    let missing = named.first().filter(|_| !named.iter().any(|known| is_known(known.name)))?;
    Some(format!("The recordings do not give the {}.", missing.label))
}

/// The words of a question in lower case of which it asks the effect.
fn cause(question: &str) -> Option<String> {
    let words: Vec<&str> = words_of(question).filter(|word| !word.is_empty()).collect();
    let text = format!(" {} ", words.join(" "));
    CAUSES.iter().find_map(|(begin, ends)| {
        let rest = text.split_once(&format!(" {begin} "))?.1;
        let end = ends.iter().filter_map(|end| rest.find(&format!(" {end} "))).min();
        let cause = rest.get(..if ends.is_empty() { rest.len() } else { end? })?;
        let cause = CONDITIONS.iter().fold(cause, |all, word| {
            all.split_once(&format!(" {word} ")).map_or(all, |(before, _)| before)
        });
        let cause = cause.trim();
        let cause = cause.strip_prefix("the ").or(cause.strip_prefix("a ")).unwrap_or(cause);
        Some(cause.to_owned()).filter(|cause| !cause.is_empty())
    })
}

/// The name of a key in words, and whether it is a number of things.
fn name_of(setting: &Coordinate) -> (String, bool) {
    let unit = unit_of_key(&setting.key);
    let words = key_words(&setting.key, unit);
    let is_number = is_number_of_things(&words, unit);
    (words, is_number)
}

/// Whether a cause is a key.
fn is_named(setting: &Coordinate, cause: &str) -> bool {
    let (words, is_number) = name_of(setting);
    let is_other_name = |(asked, meant): &(&str, &str)| *meant == words && *asked == cause;
    let name = if is_number { format!("number of {words}") } else { words.clone() };
    SYNONYMS.iter().any(is_other_name) || cause == name && !WITHIN_A_RUN.contains(&cause)
}

/// The number that a question gives for a quantity, in its unit.
fn stated_value(question: &str, words: &str, unit: &str, is_number: bool) -> Option<f64> {
    let number = |text: &str| text.parse().ok().filter(|value: &f64| value.is_finite());
    let question: String = question.replace(['?', ','], " ");
    if is_number {
        let (before, after) = question.split_once(&format!(" {words} "))?;
        // "800 discs per second" is a rate.
        let is_rate = after.trim_start().starts_with("per ");
        return number(before.split_whitespace().last().filter(|_| !is_rate)?);
    }
    let (_, after) = question.split_once(&format!("{words} "))?;
    let mut after = after.split_whitespace().skip_while(|word| ["of", "="].contains(word));
    let value = number(after.next()?)?;
    let next = after.next();
    // Of a list or a range, the runs may have another value.
    let has_unit = match unit {
        "1" => {
            next.is_none_or(|next| !["%", "percent", "times", "to", "and", "or"].contains(&next))
        }
        unit => next == Some(unit.to_lowercase().as_str()),
    };
    has_unit.then_some(value)
}

/// The keys of the model in a run with their values, without those whose quantities the table does not determine: constants of materials, and what changes
/// during the run.
fn settings(run: &RunAnalysis) -> Vec<Coordinate> {
    let changing: &[&str] = match run.model() {
        ModelConfig::Dem(dem) if !dem.materials.is_empty() || !dem.contact_pairs.is_empty() => {
            return Vec::new();
        }
        ModelConfig::Gas(gas) if !gas.keeps_energy() => &["temperature_k", "radius_m"],
        _ => &[],
    };
    let (text, model) = (run.manifest.shared_text(), run.model().name());
    let table = text.lines().skip_while(|line| !line.starts_with("[model.")).skip(1);
    let lines = table.take_while(|line| !line.starts_with('['));
    let keys = lines.filter_map(|line| line.split_once(" = "));
    let setting = |(key, value): (&str, &str)| Coordinate {
        key: format!("model.{model}.{key}"),
        value: value.strip_suffix(".0").unwrap_or(value).trim_matches('"').to_owned(),
    };
    keys.filter(|(key, _)| !changing.contains(key)).map(setting).collect()
}

/// Whether all runs have a key with this value.
fn is_common(setting: &Coordinate, source: &AnswerSource<'_>) -> bool {
    source.runs.iter().all(|run| settings(run).contains(setting))
}

#[cfg(test)]
mod tests {
    use super::{SPEED, cause, compared_kind, is_named, stated_value};
    use kinetoscope_manifest::Coordinate;

    /// Guarantee: the cause of which a question asks the effect is found. Control: a change in time has no cause.
    #[test]
    fn cause_of_an_effect_is_found_in_a_question() {
        let causes = [
            ("what does friction do?", "friction"),
            ("what does the friction change in a heap?", "friction"),
            ("how does the pressure depend on the temperature?", "temperature"),
            ("what is the effect of restitution on the rebound?", "restitution"),
            ("how does gravity influence the density?", "gravity"),
            ("how does the error depend on the time step and the method?", "time step"),
        ];
        for (question, expected) in causes {
            assert_eq!(cause(question).as_deref(), Some(expected), "{question}");
        }
        for question in
            ["how does the temperature change when the wall moves?", "what is the effect?"]
        {
            assert_eq!(cause(question), None, "{question}");
        }
    }

    /// Controls: kinds without a comparison, and a comparison without kinds.
    #[test]
    fn kinds_of_particles_are_found_in_a_comparison() {
        let of = |question: &str| compared_kind(question).map(|kind| kind.1);
        assert_eq!(of("do fast particles hit the wall more often?"), Some(SPEED));
        assert_eq!(of("how much longer do bouncier discs move?"), Some("restitution"));
        assert_eq!(of("do heavy discs settle faster?"), Some("mass"));
        assert_eq!(of("how do fast particles move?"), None);
        assert_eq!(of("how much faster do discs settle?"), None);
    }

    /// Controls: another quantity, things without their number, and a place within a run.
    #[test]
    fn cause_is_a_key_only_with_its_whole_name() {
        let of = |key: &str, cause: &str| {
            is_named(&Coordinate { key: key.to_owned(), value: "1".to_owned() }, cause)
        };
        assert!(of("model.gas.temperature_k", "temperature"));
        assert!(of("model.dem.discs", "number of discs"));
        assert!(of("model.orbit.integrator", "method"));
        assert!(!of("model.gas.temperature_k", "temperature of the wall"));
        assert!(!of("model.dem.discs", "discs"));
        assert!(!of("model.dem.height_m", "height"));
    }

    /// Controls: another unit, a list, and a percentage.
    #[test]
    fn value_of_a_question_is_read_in_its_unit_only() {
        let of =
            |question: &str, words: &str, unit: &str| stated_value(question, words, unit, false);
        assert_eq!(
            of("how high is it at a packing fraction of 0.6?", "packing fraction", "1"),
            Some(0.6)
        );
        assert_eq!(of("what is it at a temperature of 500 k?", "temperature", "K"), Some(500.0));
        assert_eq!(of("what is it at a temperature of 500 degrees?", "temperature", "K"), None);
        assert_eq!(of("what is it at friction 0.1 and 0.5?", "friction", "1"), None);
        assert_eq!(of("what is it at a restitution of 50 %?", "restitution", "1"), None);
        assert_eq!(stated_value("how do 100 discs move?", "discs", "1", true), Some(100.0));
        assert_eq!(stated_value("how do the discs move?", "discs", "1", true), None);
        assert_eq!(stated_value("how do 9 discs per second leave?", "discs", "1", true), None);
    }
}
