//! Guarantee: `[view]` names a time, a meaning of the color, and two points of the sweep that exist; it does not affect the run key, and the record of the
//! experiment contains it.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::verdicts::{experiment, rejected};
use kinetoscope_manifest::{
    ExperimentRecord, Override, ViewColor, ViewFrame, ViewRequest, parse, parse_run, run_key,
};

const SWEEP: &str = "[model.gas]\n[sweep]\nmodel.gas.temperature_k = [200.0, 250.0, 300.0]\n";

#[test]
fn view_is_read_and_recorded() {
    let view = "[view]\nposter = 0.5\ncolor = \"side\"\nframe = \"rotating\"\nnames = [\"Sun\", \"\"]\ncompare = [{ temperature_k = 250 }, { temperature_k = 300 }]\n";
    let experiment = experiment(&format!("{SWEEP}{view}"));
    assert_eq!((experiment.view.poster, experiment.view.color), (Some(0.5), Some(ViewColor::Side)));
    assert_eq!(experiment.view.frame, Some(ViewFrame::Rotating));
    assert_eq!(experiment.view.names, ["Sun", ""]);
    let compared = experiment.runs.iter().map(|run| experiment.view.compared(&run.coordinates));
    assert_eq!(compared.collect::<Vec<_>>(), [None, Some(0), Some(1)]);
    let text = ExperimentRecord::new(&experiment, []).to_toml();
    let back = ExperimentRecord::from_toml(&text, "experiment.toml").unwrap();
    assert_eq!(back.view, Some(experiment.view), "{text}");
    // Without the table, there is none in the record.
    let without = ExperimentRecord::new(&crate::verdicts::experiment(SWEEP), []).to_toml();
    assert!(!without.contains("[view]"), "{without}");
    let back = ExperimentRecord::from_toml(&without, "experiment.toml").unwrap();
    assert_eq!(back.view.unwrap_or_default(), ViewRequest::default());
}

#[test]
fn wrong_values_are_reported() {
    for (line, message) in [
        ("poster = -1.0 # <-", "must be a number >= 0"),
        ("color = \"spedd\" # <-", "did you mean \"speed\"?"),
        ("compare = [{ temperature_k = 250 }] # <-", "does not name two points of the sweep"),
        ("frame = \"rotated\" # <-", "did you mean \"rotating\"?"),
        ("compare = 3 # <-", "does not name two points of the sweep"),
        ("compare = [{ temperature_k = 251 }, { temperature_k = 300 }] # <-", "has no point"),
        ("compare = [{ temprature_k = 250 }, { temperature_k = 300 }] # <-", "is not swept"),
    ] {
        rejected(&format!("{SWEEP}[view]\n{line}\n"), message);
    }
}

#[test]
fn view_does_not_affect_the_run_key_and_cannot_be_set() {
    let key = |text: &str| run_key(&parse_run(text).unwrap().canonical(), 1, 1);
    assert_eq!(key("[model.gas]\n[view]\nposter = 1.0\n"), key("[model.gas]\n"));
    let set = [Override { key: "view.poster".to_owned(), value: "1".to_owned() }];
    let errors = parse("[model.gas]\n", "m.toml", &set).unwrap_err().to_string();
    assert!(errors.contains("`view.poster` cannot be set"), "{errors}");
}
