//! Guarantee: `metrics.json` states each definition once. Up to 1000 runs, the files contain the metrics of each run; for more, they contain
//! the means over replicates and the checks, with the same values.
//!
//! Setup: a gas at two temperatures with 501 replicates each, whose pressure is 10 N/m + the number of the replicate modulo 4, and the
//! same folder without the last replicate of each point.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::synthetic::{Folder, Frames, analyze, flat, two_frames};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::GasPressure;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;

const MANIFEST: &str = "name = \"gas\"\nreplicates = 501\n[model.gas]\nparticles = 1\nduration_s = 1.0\n\
    [record]\nframes = 1\nchannels = [\"pressure\"]\n[sweep]\n\"model.gas.temperature_k\" = [100.0, 300.0]\n\
    [[checks]]\nmetric = \"pressure.ideal_gas\"\nminimum = 11.0\n";

fn frames(run: &RunManifest) -> Frames {
    two_frames(&GasPressure {
        ideal_gas_n_per_m: 10.0 + f64::from(run.replicate % 4),
        ..GasPressure::default()
    })
}

/// `metrics.json`, and the scopes in `metrics.csv`.
fn written(folder: &Folder) -> (Value, String, BTreeSet<String>) {
    let text = fs::read_to_string(folder.path().join("metrics.json")).unwrap();
    let mut table = csv::Reader::from_path(folder.path().join("metrics.csv")).unwrap();
    let scope = table.headers().unwrap().iter().position(|name| name == "scope").unwrap();
    let scopes = table.records().map(|row| row.unwrap()[scope].to_owned()).collect();
    (serde_json::from_str(&text).unwrap(), text, scopes)
}

fn means(document: &Value) -> Vec<f64> {
    let metrics = document["metrics"].as_array().unwrap().iter();
    let means =
        metrics.filter(|it| it["name"] == "pressure.ideal_gas" && it.get("sweep").is_some());
    means.map(|mean| mean["value"].as_f64().unwrap()).collect()
}

#[test]
fn files_of_more_than_a_thousand_runs_hold_means_and_checks_only() {
    let folder = Folder::write(MANIFEST, frames);
    let output = analyze(&[folder.name()]).exited_with(0);
    assert!(flat(&output.text).contains("2 checks passed"), "{}", output.text);
    let (document, _, scopes) = written(&folder);
    assert_eq!(document["run_count"], 1002);
    assert_eq!(document["runs"].as_array().unwrap().len(), 0);
    assert_eq!(scopes, BTreeSet::from(["sweep".to_owned()]));
    // 501 replicates: 126 have the remainder 0, and 125 each the remainders 1, 2 and 3.
    let mean = 10.0 + 125.0 * (1.0 + 2.0 + 3.0) / 501.0;
    for found in means(&document) {
        assert!((found - mean).abs() < 1e-12, "{found}, not {mean}");
    }
    assert_eq!(means(&document).len(), 2);
    let checks = document["checks"].as_array().unwrap();
    assert_eq!(checks.iter().filter(|check| check["passed"] == true).count(), 2, "{checks:?}");
    let baseline = folder.path().join("metrics.json");
    let compared = analyze(&["--baseline", baseline.to_str().unwrap(), folder.name()]);
    assert_eq!(compared.code, 2);
    assert!(flat(&compared.text).contains("compared run by run"), "{}", compared.text);
    // Control: 1000 runs are all in the files, with each definition once.
    for last in [500, 1001] {
        fs::remove_file(folder.file(last)).unwrap();
    }
    analyze(&[folder.name()]).exited_with(0);
    let (document, text, scopes) = written(&folder);
    assert_eq!(document["runs"].as_array().unwrap().len(), 1000);
    assert_eq!(scopes.len(), 2);
    assert_eq!(means(&document), [11.5, 11.5]);
    let definitions = || document["definitions"].as_object().unwrap().values();
    for definition in definitions() {
        // Slope and intercept of a line have the same text.
        let source = definition["source"].to_string();
        let defined = definitions().filter(|it| it["source"] == definition["source"]).count();
        assert_eq!(text.matches(&source).count(), defined, "{source}");
    }
    for metric in document["metrics"].as_array().unwrap() {
        let laws = &document["definitions"][metric["name"].as_str().unwrap()]["laws"];
        let is_named =
            metric["theory"]["law"].as_u64().is_none_or(|at| !laws[at as usize].is_null());
        assert!(is_named, "{metric}");
    }
}
