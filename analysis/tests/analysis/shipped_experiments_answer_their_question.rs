//! Guarantee: every shipped experiment states its question and an answer with a measured number, whose references are those of its
//! model and its sweep. The words of an answer contain no name of a metric.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use kinetoscope_analysis::{fitted_along, metric_names, unit_of};
use kinetoscope_manifest::{AnswerPart, Lookup, parse_with};
use std::path::Path;

#[test]
fn every_shipped_experiment_has_a_question_and_an_answer() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let source = std::fs::read_to_string(&path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy();
        let lookup = Lookup {
            metrics: Some(metric_names),
            fitted_along: Some(fitted_along),
            unit_of: Some(unit_of),
            ..Lookup::default()
        };
        let experiment = parse_with(&source, &name, &[], lookup).unwrap();
        assert!(experiment.question.ends_with('?'), "{name}: {}", experiment.question);
        let parts = experiment.answer.as_ref().unwrap_or_else(|| panic!("{name}")).parts();
        let metrics = metric_names(experiment.model());
        let mut numbers = 0;
        for part in parts {
            match part {
                AnswerPart::Metric(reference) => numbers += u32::from(!reference.is_theory),
                AnswerPart::Text(text) => {
                    let named = metrics.iter().find(|it| it.contains('.') && text.contains(**it));
                    assert_eq!(named, None, "{name}: {text}");
                }
            }
        }
        assert!(numbers > 0, "{name} answers without a number");
        count += 1;
    }
    assert!(count > 50, "{count} experiments");
}
