//! Guarantee: `docs/metrics.md` equals the program's table of metrics, and `metrics.json` conforms to its schema.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::synthetic::{Folder, Frames, two_frames};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::GasPressure;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

fn document(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(name);
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn metrics_reference_equals_the_table() {
    assert!(
        document("metrics.md") == kinetoscope_analysis::metrics_reference(),
        "docs/metrics.md is out of date; run `cargo run --bin analyze-recordings -- --list-metrics > docs/metrics.md`"
    );
}

const MANIFEST: &str = r#"
name = "gas"
replicates = 2
[model.gas]
particles = 1
duration_s = 1.0
[record]
frames = 1
channels = ["state", "pressure"]
[sweep]
"model.gas.temperature_k" = [100.0, 300.0]
"#;

fn frames(_: &RunManifest) -> Frames {
    two_frames(&GasPressure::default())
}

/// The required and the allowed fields of an object in the schema.
fn fields(schema: &Value) -> (BTreeSet<String>, BTreeSet<String>) {
    let required = schema["required"].as_array().unwrap().iter();
    let known = schema["properties"].as_object().unwrap().keys().cloned().collect();
    (required.map(|name| name.as_str().unwrap().to_owned()).collect(), known)
}

fn assert_fits(object: &Value, schema: &Value) {
    let (required, known) = fields(schema);
    let found: BTreeSet<String> = object.as_object().unwrap().keys().cloned().collect();
    assert!(found.is_superset(&required), "{found:?} lacks some of {required:?}");
    assert!(found.is_subset(&known), "{found:?} has more than {known:?}");
}

#[test]
fn metrics_file_conforms_to_its_schema() {
    let folder = Folder::write(MANIFEST, frames);
    folder.metrics();
    let file: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("metrics.json")).unwrap())
            .unwrap();
    let schema: Value = serde_json::from_str(&document("metrics.schema.json")).unwrap();
    assert_fits(&file, &schema);
    assert_eq!(file["schema"], schema["properties"]["schema"]["const"]);
    let [of_metric, of_run, of_theory] =
        ["metric", "run", "theory"].map(|name| &schema["$defs"][name]);
    for run in file["runs"].as_array().unwrap() {
        assert_fits(run, of_run);
        let coordinate = serde_json::json!({ "value": run["coordinates"]["temperature_k"]["value"], "unit": "K" });
        assert_eq!(run["coordinates"]["temperature_k"], coordinate);
        assert!(coordinate["value"].is_number());
        let in_manifest: f64 =
            run["manifest"]["model.gas.temperature_k"].as_str().unwrap().parse().unwrap();
        assert_eq!(Some(in_manifest), coordinate["value"].as_f64());
    }
    let metrics = file["metrics"].as_array().unwrap();
    for metric in metrics {
        assert_fits(metric, of_metric);
        if !metric["theory"].is_null() {
            assert_fits(&metric["theory"], of_theory);
        }
        for place in ["run", "sweep"] {
            if let Some(found) = metric.get(place) {
                assert_fits(found, &of_metric["properties"][place]);
            }
        }
    }
    for place in ["run", "sweep", "theory"] {
        let has_one = metrics.iter().any(|metric| metric.get(place).is_some_and(Value::is_object));
        assert!(has_one, "no metric has {place}");
    }
}
