//! Guarantee: a check that passes is reported as `ok`. A check that fails, or whose metric is missing, is reported with the measured, expected
//! and allowed values, and the exit code is 3. The same recordings give the same bytes.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::synthetic::{Folder, Frames, analyze, flat, frames_of, two_frames};
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::model::{ModelConfig, SpeedScale};
use kinetoscope_recording::channels::{GasInvariants, GasPressure};
use std::fs;

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
[[checks]]
metric = "pressure.measured"
where = { temperature_k = 100.0 }
expected = 100.5
tolerance = 0.6
[[checks]]
metric = "pressure_vs_temperature.measured.slope"
expected = 1.0
relative_tolerance = 1e-9
"#;

/// Pressure T + replicate: means T + 0.5, slope 1.
fn frames(run: &RunManifest) -> Frames {
    let ModelConfig::Gas(config) = &*run.model else { panic!("expected the gas model") };
    let SpeedScale::Temperature(temperature) = config.speed_scale else {
        panic!("expected a temperature")
    };
    two_frames(&GasPressure {
        measured_since_start_n_per_m: temperature.get() + f64::from(run.replicate),
        ..GasPressure::default()
    })
}

#[test]
fn passing_checks_exit_with_zero() {
    let folder = Folder::write(MANIFEST, frames);
    let output = analyze(&["--all", folder.name()]).exited_with(0);
    let line =
        "ok pressure.measured at temperature_k = 100: measured 100.5 N/m, expected 100.5 ± 0.6";
    assert!(flat(&output.text).contains(line), "{}", output.text);
}

#[test]
fn failed_check_states_measured_expected_and_tolerance() {
    let folder = Folder::write(&MANIFEST.replace("100.5", "99.0"), frames);
    let output = analyze(&[folder.name()]).exited_with(3);
    let line =
        "FAILED pressure.measured at temperature_k = 100: measured 100.5 N/m, expected 99 ± 0.6";
    assert!(flat(&output.text).contains(line), "{}", output.text);
    assert!(output.text.contains("1 of 2 checks failed"), "{}", output.text);
}

#[test]
fn checks_of_a_file_are_applied_and_a_missing_metric_fails() {
    let folder = Folder::write(MANIFEST, frames);
    let checks = folder.path().join("more.toml");
    let analyzed_with = |text: &str| {
        fs::write(&checks, text).unwrap();
        analyze(&["--checks", checks.to_str().unwrap(), folder.name()])
    };
    let output =
        analyzed_with("[[checks]]\nmetric = \"pressure.measured\"\nminimum = 100\nmaximum = 301\n");
    assert_eq!(output.code, 0, "{}", output.text);
    // Without coordinates, the check applies to every point.
    let output = analyzed_with("[[checks]]\nmetric = \"pressure.measured\"\nmaximum = 200\n");
    assert_eq!(output.code, 3, "{}", output.text);
    let output = analyzed_with("[[checks]]\nmetric = \"pressure.mesured\"\nminimum = 0\n");
    assert_eq!(output.code, 2, "{}", output.text);
    assert!(flat(&output.text).contains("did you mean `pressure.measured`?"), "{}", output.text);
    let output = analyzed_with(
        "[[checks]]\nmetric = \"pressure.measured\"\nwhere = { temperature_k = 7 }\nminimum = 0\n",
    );
    assert_eq!(output.code, 3, "{}", output.text);
    assert_eq!(analyzed_with("[[checks]]\nmetric = 3\n").code, 2);
    let missing = folder.path().join("nothing.toml");
    analyze(&["--checks", missing.to_str().unwrap(), folder.name()]).exited_with(2);
}

/// The checks of an experiment do not apply to a part of it.
#[test]
fn checks_of_the_experiment_do_not_apply_to_single_files() {
    let folder = Folder::write(&MANIFEST.replace("100.5", "99.0"), frames);
    analyze(&[folder.file(0).to_str().unwrap()]).exited_with(0);
}

#[test]
fn results_do_not_depend_on_the_folder() {
    let folder = Folder::write(MANIFEST, frames);
    let output = |arguments: &[&str]| {
        let directory = tempfile::TempDir::new().unwrap();
        let mut all = vec!["--output", directory.path().to_str().unwrap()];
        all.extend(arguments);
        assert_eq!(analyze(&all).code, 0);
        let mut files: Vec<_> = fs::read_dir(directory.path())
            .unwrap()
            .map(|entry| entry.unwrap().path())
            // The analysis cache is a folder; it contains modification times.
            .filter(|path| path.is_file())
            .map(|path| (path.file_name().unwrap().to_owned(), fs::read(&path).unwrap()))
            .collect();
        files.sort();
        files
    };
    let first = output(&[folder.name()]);
    assert_eq!(first, output(&[folder.name()]));
    let moved = tempfile::TempDir::new().unwrap();
    let elsewhere = moved.path().join("elsewhere");
    fs::create_dir(&elsewhere).unwrap();
    for entry in fs::read_dir(folder.path()).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            continue;
        }
        fs::copy(&path, elsewhere.join(path.file_name().unwrap())).unwrap();
    }
    assert_eq!(first, output(&[elsewhere.to_str().unwrap()]));
    let names: Vec<String> =
        first.iter().map(|(name, _)| name.to_string_lossy().into_owned()).collect();
    for name in ["metrics.json", "metrics.csv", "pressure_vs_temperature.svg"] {
        assert!(names.iter().any(|other| other == name), "{names:?}");
    }
    let parent = folder.path().to_string_lossy().into_owned();
    for (name, content) in &first {
        let text = String::from_utf8_lossy(content);
        assert!(!text.contains(&parent), "{name:?} contains a path");
        assert!(!name.to_string_lossy().ends_with(".new"));
    }
}

/// `metrics.csv` has one line per metric, with the same numbers as `metrics.json`, and one column per coordinate.
#[test]
fn csv_and_json_agree() {
    let folder = Folder::write(MANIFEST, frames);
    let metrics = folder.metrics();
    let text = fs::read_to_string(folder.path().join("metrics.csv")).unwrap();
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().unwrap().clone();
    assert_eq!(
        header.iter().take(4).collect::<Vec<_>>(),
        ["temperature_k", "replicate", "metric", "value"]
    );
    let mut names: Vec<&str> = header.iter().collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), header.len(), "a column has two values: {header:?}");
    let rows: Vec<csv::StringRecord> = reader.records().map(|record| record.unwrap()).collect();
    let rows: Vec<_> = rows.iter().filter(|row| &row[2] == "pressure.measured").collect();
    let values: Vec<f64> = rows.iter().map(|row| row[3].parse().unwrap()).collect();
    let points: Vec<[&str; 2]> = rows.iter().map(|row| [&row[0], &row[1]]).collect();
    assert_eq!(points[..3], [["100", ""], ["300", ""], ["100", "0"]]);
    let expected: Vec<f64> = metrics
        .all("pressure.measured")
        .iter()
        .map(|metric| metric["value"].as_f64().unwrap())
        .collect();
    assert_eq!(values, expected);
    assert_eq!(values.len(), 2 + 4);
}

/// Guarantee: a gas that loses particles fails without any check, in the text and at the head of the page; a check of the loss decides
/// instead. Control: no particle is lost.
#[test]
fn lost_particles_fail_unless_a_check_expects_them() {
    let manifest = "name = \"gas\"\n[model.gas]\nparticles = 5\nduration_s = 1.0\n[record]\nframes = 1\nchannels = [\"energy\"]\n";
    let lost = |lost: u64| {
        move |_: &RunManifest| {
            frames_of(0..2, |index, frame| {
                frame.push(&GasInvariants { particles_outside: lost, ..GasInvariants::default() });
                f64::from(index)
            })
        }
    };
    let folder = Folder::write(manifest, lost(2));
    let output = analyze(&[folder.name()]).exited_with(3);
    let headline = "FAILED: 1 of 1 run without the expected outcome: gas__000.mcap: particles_outside = 2; if that is expected, add a check of it";
    assert!(flat(&output.text).contains(headline), "{}", output.text);
    assert!(output.text.contains("1 of 1 run ended otherwise than expected"), "{}", output.text);
    assert!(folder.page().contains(headline));
    analyze(&[Folder::write(manifest, lost(0)).name()]).exited_with(0);
    let expected = format!("{manifest}[[checks]]\nmetric = \"particles_outside\"\nminimum = 2\n");
    analyze(&[Folder::write(&expected, lost(2)).name()]).exited_with(0);
}
