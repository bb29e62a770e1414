//! Guarantee: `answer` names metrics and points of the sweep that exist, each with one value, and an error is reported at its place in the
//! sentence. Question and answer do not affect the run key.

// A test may panic.
#![allow(clippy::unwrap_used)]

use crate::verdicts::metrics;
use kinetoscope_manifest::{
    AnswerPart, Experiment, ExperimentRecord, Lookup, MetricReference, parse_with, run_key,
};

const SWEEP: &str = "[model.gas]\n[sweep]\nmodel.gas.temperature_k = [200, 300]\n\
    [[sweep.variants]]\nname = \"a, b\"\n[[sweep.variants]]\nname = \"c\"\n";

/// The fit of these tests is along the temperature.
fn fitted_along(metric: &str) -> Vec<&'static str> {
    if metric == "a2" { vec!["model.gas.temperature_k"] } else { Vec::new() }
}

fn read(text: &str) -> Result<Experiment, String> {
    let lookup = Lookup {
        metrics: Some(metrics),
        fitted_along: Some(fitted_along),
        unit_of: Some(|metric| if metric == "mean_speed" { Some("m/s") } else { Some("1") }),
        ..Lookup::default()
    };
    parse_with(text, "m.toml", &[], lookup).map_err(|errors| errors.to_string())
}

fn answered(answer: &str) -> Result<Experiment, String> {
    read(&format!("answer = '{answer}'\n{SWEEP}"))
}

fn references(experiment: &Experiment) -> Vec<MetricReference> {
    let parts = experiment.answer.as_ref().unwrap().parts().iter();
    let references = parts.filter_map(|part| match part {
        AnswerPart::Metric(reference) => Some(reference.clone()),
        AnswerPart::Text(_) => None,
    });
    references.collect()
}

#[test]
fn reference_selects_one_point_and_a_form() {
    let text = r#"{{x}} = {pressure.measured size in percent to 4 digits @ temperature_k = 3e2, variant = "a, b"}, {a2 theory @ variant = c}"#;
    let experiment = answered(text).unwrap();
    let [first, second] = references(&experiment).try_into().unwrap();
    assert!(first.is_size && first.is_in_percent && !first.is_theory && second.is_theory);
    assert_eq!(first.digits, Some(4));
    let selected = experiment.runs.iter().filter(|run| first.selects(&run.coordinates));
    let selected: Vec<_> = selected.map(|run| run.coordinates[0].value.as_str()).collect();
    assert_eq!(selected, ["300"]);
    let words = &experiment.answer.as_ref().unwrap().parts()[0];
    assert_eq!(*words, AnswerPart::Text("{x} = ".to_owned()));
}

#[test]
fn wrong_reference_is_reported_at_its_place() {
    let long = "x".repeat(10_000);
    let all = "@ temperature_k = 200, variant = c";
    for (answer, part, message) in [
        (&*format!("{{mean_sped {all}}}"), "{mean_sped", "did you mean `mean_speed`?"),
        (&format!("{{zzz {all}}}"), "{zzz", "lists all metrics"),
        ("x {mean_speed", "{mean_speed", "this brace is not closed"),
        ("x } y", "} y", "this brace closes nothing"),
        ("{}", "{}", "no metric between the braces"),
        (
            "{mean_speed @ variant = c}",
            "{mean_speed",
            "name the point, such as `@ temperature_k = 200`",
        ),
        ("{mean_speed @ variant = d, temperature_k = 200}", "{mean_speed", "values: a, b, c"),
        (
            "{mean_speed @ temperature = 200, variant = c}",
            "{mean_speed",
            "did you mean `temperature_k`?",
        ),
        ("{mean_speed @ temperature_k, variant = c}", "{mean_speed", "write `@ KEY = VALUE"),
        ("{mean_speed in inches}", "{mean_speed", "`in inches` is not a form of a number"),
        ("{mean_speed to 99 digits}", "{mean_speed", "from 1 to 12"),
        (
            &format!("{{mean_speed in percent {all}}}"),
            "{mean_speed",
            "`mean_speed` is in m/s, not a pure number",
        ),
        ("{a2 @ temperature_k = 200, variant = c}", "{a2", "is one number for all values of"),
        ("{a2}", "{a2", "has one value for each value of variant"),
        (" ", " ", "leave it out"),
        (&long, "xx", "must have at most 1000"),
    ] {
        let errors = answered(answer).unwrap_err();
        assert!(errors.contains(message), "{answer}: {message}\n{errors}");
        let column = "answer = '".len() + answer.find(part).unwrap() + 1;
        assert!(errors.contains(&format!("m.toml:1:{column}")), "{column} {errors}");
        assert_eq!(errors.matches("error: ").count(), 1, "{errors}");
    }
    let control = format!("answer = \"a\\u001b[2J\"\n{SWEEP}");
    assert!(read(&control).unwrap_err().contains("U+001B"));
    let unswept = read("answer = '{a2}'\n[model.gas]\n").unwrap_err();
    assert!(unswept.contains("which is not swept"), "{unswept}");
    // Control: one run needs no point.
    read("answer = '{mean_speed}'\n[model.gas]\n").unwrap();
}

#[test]
fn question_is_the_key_or_a_comment_with_a_question_mark() {
    let question = |text: &str| read(text).unwrap().question;
    assert_eq!(question("# Do they? Expected: yes.\n[model.gas]\n"), "Do they?");
    assert_eq!(question("# Do they\n# fall? Expected:\n# yes.\n[model.gas]\n"), "Do they fall?");
    assert_eq!(question("# Do they?\n# More.\n[model.gas]\n"), "Do they?");
    assert_eq!(question("# Every key is listed.\n[model.gas]\n"), "");
    assert_eq!(question("# Do they?\nquestion = \"Why?\"\n[model.gas]\n"), "Why?");
}

/// A question has the limits of an answer. A comment beyond them is no question.
#[test]
fn question_is_short_and_has_words_only() {
    let stated = |text: &str| read(&format!("question = {text}\n[model.gas]\n"));
    let long = format!("\"{}?\"", "x".repeat(1000));
    for (question, message) in [
        ("\"\"", "`question` is empty"),
        ("\"  \"", "`question` is empty"),
        (&long, "`question` has 1001 characters"),
        ("\"a\\u001b[2J?\"", "U+001B"),
    ] {
        let errors = stated(question).unwrap_err();
        assert!(errors.contains(message) && errors.contains("m.toml:1:1"), "{message}\n{errors}");
        assert_eq!(errors.matches("error: ").count(), 1, "{errors}");
    }
    let comment = format!("# {}?\n[model.gas]\n", "x".repeat(1000));
    assert_eq!(read(&comment).unwrap().question, "");
    // Control: the longest question.
    stated(&format!("\"{}?\"", "x".repeat(999))).unwrap();
    assert_eq!(read(&comment.replacen('x', "", 1)).unwrap().question.len(), 1000);
}

#[test]
fn answer_is_recorded_and_changes_no_run_key() {
    let plain = read(SWEEP).unwrap();
    let answer = r#"Say "{mean_speed @ temperature_k = 200, variant = "a, b"}"."#;
    let text = format!("question = \"Why?\"\nanswer = '{answer}'\n{SWEEP}");
    let with_answer = read(&text).unwrap();
    let keys = |experiment: &Experiment| -> Vec<_> {
        experiment.runs.iter().map(|run| run_key(&run.manifest.canonical(), 1, 1)).collect()
    };
    assert_eq!(keys(&plain), keys(&with_answer));
    let files = keys(&with_answer).into_iter().map(|key| (key.to_string(), key));
    let record = ExperimentRecord::new(&with_answer, files);
    let back = ExperimentRecord::from_toml(&record.clone().to_toml(), "experiment.toml").unwrap();
    assert_eq!((back.question.as_str(), &back.answer), ("Why?", &with_answer.answer));
    assert_eq!(back, record);
}
