//! Yes or no to a question that can be answered so, where the values decide it: a quantity that is to be kept, a law that is to hold, and a dependence.

use super::AnswerPart;
use super::question::{asks_if_kept, words_of};
use super::unanswered::compared_kind;
use crate::metric::{Deviation, Metric};

/// The words with which such a question begins.
const FIRST: [&str; 12] =
    ["do", "does", "did", "is", "are", "was", "were", "will", "can", "has", "have", "must"];
/// Beginnings of words that ask whether a law holds.
const AGREES: [&str; 7] = ["agree", "obey", "follow", "hold", "satisf", "match", "equal"];
/// Words for a law.
const LAWS: [&str; 6] = ["law", "theory", "distribution", "equation", "formula", "prediction"];
/// Beginnings of words that ask whether there is a dependence, a rise or a fall.
const DEPENDS: [&str; 4] = ["depend", "affect", "influence", "matter"];
const RISES: [&str; 8] =
    ["rise", "grow", "increase", "more", "higher", "larger", "longer", "faster"];
const FALLS: [&str; 8] =
    ["fall", "shrink", "decrease", "less", "lower", "smaller", "shorter", "slower"];

/// Words of a question that asks how much: the direction of a change does not decide it.
const QUALIFIES: [&str; 14] = [
    "than",
    "by",
    "above",
    "below",
    "within",
    "double",
    "triple",
    "twice",
    "half",
    "linearly",
    "quadratically",
    "exponentially",
    "always",
    "only",
];

/// Beginnings of the labels of changes.
const CHANGES: [&str; 5] = [
    "change of",
    "largest change of",
    "largest relative error of",
    "relative change of",
    "relative growth of",
];
/// A relative change up to this is none, and one from the other on is one.
const LARGEST_KEPT: f64 = 1e-3;
const LEAST_CHANGED: f64 = 1e-2;

/// Standard errors up to which a law holds, and from which on it does not.
const HOLDS: f64 = 2.0;
const IS_VIOLATED: f64 = 5.0;

/// The sentence with the answer in front of it, if its values decide a question in lower case.
pub(super) fn decided(
    question: &str,
    mut sentence: Vec<AnswerPart>,
    metrics: &[&Metric],
) -> Vec<AnswerPart> {
    let text: String = sentence.iter().map(AnswerPart::text).collect();
    if let Some(answer) = answer(question, &text, metrics)
        && let Some(AnswerPart::Text(first)) = sentence.first_mut()
    {
        let mut letters = first.chars();
        let begin = letters.next().map(|letter| letter.to_lowercase().to_string());
        // An abbreviation keeps its capitals.
        let is_word = letters.as_str().starts_with(|letter: char| !letter.is_uppercase());
        let rest = begin.filter(|_| is_word).map(|begin| begin + letters.as_str());
        let word = if answer { "Yes" } else { "No" };
        *first = format!("{word}: {}", rest.unwrap_or_else(|| first.clone()));
    }
    sentence
}

/// Whether the answer is yes; `None` for other questions, for several in one, and where the values do not decide it.
fn answer(question: &str, sentence: &str, metrics: &[&Metric]) -> Option<bool> {
    let words: Vec<&str> = words_of(question).filter(|word| !word.is_empty()).collect();
    let asks = |beginnings: &[&str]| {
        words.iter().any(|word| beginnings.iter().any(|begin| word.starts_with(begin)))
    };
    if !FIRST.contains(words.first()?) || words.contains(&"and") || words.contains(&"or") {
        return None;
    }
    // A statement with a negation may be true where the one without it is not.
    if words.contains(&"not") || words.contains(&"no") {
        return None;
    }
    let has_number = question.contains(|letter: char| letter.is_ascii_digit());
    if has_number || words.iter().any(|word| QUALIFIES.contains(word)) {
        return None;
    }
    if let Some((verb, key)) = dependence(sentence) {
        let kind = compared_kind(question).filter(|kind| key.ends_with(kind.1));
        let is_asked =
            kind.is_some() || words_of(key).last().is_some_and(|last| words.contains(&last));
        // Cold, light and small particles have less of the key.
        let is_less = kind.is_some_and(|(kind, _)| {
            ["cold", "light", "small"].iter().any(|begin| kind.starts_with(begin))
        });
        return match verb {
            _ if !is_asked => None,
            _ if words.contains(&"proportional") => match verb {
                _ if words.contains(&"square") || words.contains(&"inversely") => None,
                _ => Some(verb == "is proportional to the"),
            },
            "hardly depends on the" => {
                (asks(&DEPENDS) || asks(&RISES) || asks(&FALLS)).then_some(false)
            }
            _ if asks(&DEPENDS) => Some(true),
            verb => {
                let is_rise =
                    ["rises with the", "is proportional to the"].contains(&verb) != is_less;
                match (asks(&RISES), asks(&FALLS)) {
                    (true, false) => Some(is_rise),
                    (false, true) => Some(!is_rise),
                    _ => None,
                }
            }
        };
    }
    if asks_if_kept(question) {
        return is_kept(metrics);
    }
    let names_law = words.iter().any(|word| LAWS.contains(word));
    if asks(&AGREES) && names_law { is_law_kept(metrics) } else { None }
}

/// The verb of a dependence in a sentence, with the key after it.
fn dependence(sentence: &str) -> Option<(&'static str, &str)> {
    const VERBS: [&str; 5] = [
        "hardly depends on the",
        "is inversely proportional to the",
        "is proportional to the",
        "rises with the",
        "falls with the",
    ];
    VERBS.iter().find_map(|verb| {
        let after = sentence.split_once(&format!(" {verb} "))?.1;
        let is_power = after.starts_with("square");
        let key =
            after.split(" within").next()?.split(" by only").next()?.split([',', '(']).next()?;
        let verb =
            if is_power && *verb == "is proportional to the" { "rises with the" } else { verb };
        Some((verb, key.trim()))
    })
}

/// Whether changes are so small, or so large, that a quantity is kept, or is not.
fn is_kept(metrics: &[&Metric]) -> Option<bool> {
    let is_change = |metric: &&Metric| {
        let label = metric.definition.label;
        let is_change = CHANGES.iter().any(|begin| label.starts_with(begin));
        metric.unit() == "1" && (is_change || metric.is_of_conservation_law())
    };
    let size = |metric: &&Metric| metric.value().abs();
    match metrics {
        [] => None,
        all if !all.iter().all(is_change) => None,
        all if all.iter().all(|metric| size(metric) <= LARGEST_KEPT) => Some(true),
        all if all.iter().all(|metric| size(metric) >= LEAST_CHANGED) => Some(false),
        _ => None,
    }
}

/// Whether all values are so close to their law, or one so far from it, that it holds, or does not.
fn is_law_kept(metrics: &[&Metric]) -> Option<bool> {
    let is_close = |metric: &&Metric| match metric.deviation()? {
        Deviation::Rounding | Deviation::Bound { is_inside: true } => Some(true),
        Deviation::Bound { is_inside: false } => Some(false),
        Deviation::StandardErrors(sigma) if sigma.abs() <= HOLDS => Some(true),
        Deviation::StandardErrors(sigma) if sigma.abs() >= IS_VIOLATED => Some(false),
        Deviation::StandardErrors(_) | Deviation::Bare(_) => None,
    };
    let all: Option<Vec<bool>> = metrics.iter().map(is_close).collect();
    all.filter(|all| !all.is_empty()).map(|all| all.iter().all(|is_close| *is_close))
}

#[cfg(test)]
mod tests {
    use super::answer;

    /// Controls: other questions, two in one, a negation, another key, and a sentence without a dependence.
    #[test]
    fn dependence_decides_a_question() {
        let sentence =
            |verb: &str| format!("The pressure on the wall {verb} temperature, from 1 N/m");
        let of = |question: &str, verb: &str| answer(question, &sentence(verb), &[]);
        let [proportional, falls, hardly] =
            ["is proportional to the", "falls with the", "hardly depends on the"];
        assert_eq!(of("does the pressure rise with the temperature?", proportional), Some(true));
        assert_eq!(of("does the pressure rise with the temperature?", falls), Some(false));
        assert_eq!(of("does the pressure depend on the temperature?", hardly), Some(false));
        assert_eq!(of("does the pressure fall with the temperature?", falls), Some(true));
        let asked = "is the pressure proportional to the temperature?";
        assert_eq!(of(asked, proportional), Some(true));
        assert_eq!(of(asked, "is proportional to the square of the"), Some(false));
        for question in [
            "how does the pressure rise with the temperature?",
            "does it rise with the temperature or fall?",
            "does it not rise with the temperature?",
            "does the pressure rise with the mass?",
            "does the pressure rise faster than the temperature?",
            "does the pressure more than double with the temperature?",
            "does the pressure rise by 50 % with the temperature?",
        ] {
            assert_eq!(of(question, proportional), None, "{question}");
        }
        assert_eq!(of(asked, "is at a"), None);
        assert_eq!(of("do hot particles press more?", proportional), Some(true));
        assert_eq!(of("do cold particles press more?", proportional), Some(false));
        // A hotter gas has fast and slow particles, too.
        assert_eq!(of("do fast particles press more?", proportional), None);
    }
}
