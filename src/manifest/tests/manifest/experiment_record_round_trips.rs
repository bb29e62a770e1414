//! Guarantee: `experiment.toml`, written next to the recordings, gives the analysis the same experiment as the manifest gave the run.

// A test may panic.
#![allow(clippy::unwrap_used)]

use crate::verdicts::{accepted, errors, experiment, metrics, rejected};
use kinetoscope_manifest::{
    Bound, Check, Coordinate, ExperimentRecord, parse, parse_checks, run_key,
};

const CHECKS: &str = r#"
[[checks]]
metric = "pressure.measured"
expected = -4.395e-21
tolerance = 1e-22
where = { "model.gas.temperature_k" = 300.0, variant = "b \"quoted\"" }
[[checks]]
metric = "pressure.ideal_gas"
relative_tolerance = 0.02
[[checks]]
metric = "mean_speed"
standard_errors = 4
[[checks]]
metric = "a2"
maximum = 1
"#;

const BASELINE: &str = "[[baseline]]\nmetric = \"mean_speed\"\nrelative_tolerance = 0.01\n";

fn record() -> ExperimentRecord {
    let text = format!(
        "# Why? Expected: \"so\".\n#\n# Second <part>\ndescription = \"two\\nlines, \\\"quoted\\\", \\\\ and \\u0007\"\nreplicates = 2\n[model.gas]\n[sweep]\n\
         model.gas.temperature_k = [200, 300]\n[[sweep.variants]]\nname = \"a\"\n[[sweep.variants]]\nname = \"b \\\"quoted\\\"\"\n{CHECKS}{BASELINE}"
    );
    let experiment = experiment(&text);
    let files = experiment.runs.iter().map(|run| {
        let key = run_key(&run.manifest.canonical(), 1, 1);
        (format!("{}.mcap", run.file_stem(&experiment.name, &key, experiment.replicates)), key)
    });
    ExperimentRecord::new(&experiment, files)
}

#[test]
fn record_is_read_back() {
    let record = record();
    assert_eq!(record.runs.len(), 8);
    assert_eq!(record.model, "gas");
    let text = record.clone().to_toml();
    let back = ExperimentRecord::from_toml(&text, "experiment.toml")
        .unwrap_or_else(|errors| panic!("{errors}\n{text}"));
    assert_eq!(back, record);
    assert_eq!(back.baseline.len(), 1);
    assert_eq!(back.baseline[0].relative_tolerance, 0.01);
}

/// Guarantee: the report gets the question from the first comment lines. Control: comments below a key are not part of it.
#[test]
fn comment_at_the_start_is_kept() {
    assert_eq!(record().comment, "Why? Expected: \"so\".\n\nSecond <part>");
    let comment = |text: &str| experiment(text).comment;
    assert_eq!(comment("seed = 1\n# later\n[model.gas]\n"), "");
    assert_eq!(comment("#one\r\n\r\n# two\r\n[model.gas]\r\n"), "one");
    let long = format!("# first\n# {}\n[model.gas]\n", "x".repeat(3000));
    assert_eq!(comment(&long), "first");
}

#[test]
fn checks_are_read_from_a_separate_file() {
    let checks = parse_checks(CHECKS, "checks.toml", Some(metrics)).unwrap();
    let without_lines = |checks: &[Check]| -> Vec<Check> {
        checks.iter().map(|check| Check { line: 0, ..check.clone() }).collect()
    };
    assert_eq!(without_lines(&checks), without_lines(&record().checks));
    assert_eq!([checks[0].line, checks[1].line], [2, 7]);
    assert_eq!(checks[0].bound, Bound::Near { expected: Some(-4.395e-21), tolerance: 1e-22 });
    assert_eq!(checks[1].bound, Bound::NearRelative { expected: None, relative_tolerance: 0.02 });
    assert_eq!(
        checks[2].bound,
        Bound::WithinStandardErrors { expected: None, standard_errors: 4.0 }
    );
    assert_eq!(checks[3].bound, Bound::Range { minimum: None, maximum: Some(1.0) });
    let other =
        parse_checks("seed = 1\n[[checks]]\nmetric = \"a2\"\n", "c.toml", None).unwrap_err();
    assert_eq!(other.len(), 2, "{other}");
    assert!(parse_checks("", "c.toml", None).unwrap_err().to_string().contains("no [[checks]]"));
}

#[test]
fn unknown_metrics_are_rejected_with_the_nearest_name() {
    let check = "[[checks]]\nmetric = \"pressure.mesured\"\nminimum = 0\n";
    for errors in [
        parse_checks(check, "c.toml", Some(metrics)).unwrap_err().to_string(),
        errors(&format!("[model.gas]\n{check}")).to_string(),
    ] {
        assert!(errors.contains("`pressure.mesured` is not a metric"), "{errors}");
        assert!(errors.contains("did you mean `pressure.measured`?"), "{errors}");
    }
    // The metric of another model is not one of the gas, but a file of checks has no model.
    let other = check.replace("pressure.mesured", "bed.height");
    rejected(&format!("[model.gas]\n{other}"), "`bed.height` is not a metric");
    assert!(parse_checks(&other, "c.toml", Some(metrics)).is_ok());
    // Control: where the metrics are not known, the analysis compares the names.
    assert!(parse_checks(check, "c.toml", None).is_ok());
    assert!(parse(&format!("[model.gas]\n{check}"), "c.toml", &[]).is_ok());
}

#[test]
fn checks_select_by_coordinates() {
    let at = |key: &str, value: &str| Coordinate { key: key.to_owned(), value: value.to_owned() };
    let checks = record().checks;
    let place = [at("model.gas.temperature_k", "300"), at("variant", "b \"quoted\"")];
    assert!(checks[0].selects(&place));
    assert!(!checks[0].selects(&place[..1]));
    assert!(!checks[0].selects(&[at("model.gas.temperature_k", "200"), place[1].clone()]));
    assert!(checks[1].selects(&place) && checks[1].selects(&[]));
}

#[test]
fn damaged_record_is_reported() {
    let text = record().to_toml();
    let short = text.replacen("run_key = \"", "run_key = \"0", 1);
    let errors = ExperimentRecord::from_toml(&short, "experiment.toml").unwrap_err().to_string();
    assert!(errors.contains("must be 64 hexadecimal digits"), "{errors}");
    let errors =
        ExperimentRecord::from_toml("name = \"a\"\n", "experiment.toml").unwrap_err().to_string();
    assert!(errors.contains("experiment.toml: unknown model \"\""), "{errors}");
}

/// The tolerance of an unknown metric is an error with the nearest name; so are two tolerances of one metric, and none.
#[test]
fn baseline_tolerances_are_checked() {
    let rejected = |text: &str, expected: &str| rejected(&format!("[model.gas]\n{text}"), expected);
    rejected(&BASELINE.replace("mean_speed", "mean_sped"), "did you mean `mean_speed`?");
    rejected(&BASELINE.repeat(2), "one tolerance for each metric");
    rejected("[[baseline]]\nmetric = \"mean_speed\"\n", "needs `relative_tolerance`");
    rejected("[[baseline]]\nrelative_tolerance = 1\n", "needs `metric`");
    rejected(&BASELINE.replace("0.01", "-1"), "relative_tolerance");
    accepted(&format!("[model.gas]\n{BASELINE}"));
}
