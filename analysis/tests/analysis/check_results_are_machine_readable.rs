//! Guarantee: JUnit files and GitHub annotations contain the results of the terminal, the workflow in
//! docs/ works unchanged, and unchanged recordings are not read again.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::synthetic::{Folder, Frames, analyze, two_frames};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::GasPressure;
use std::collections::BTreeSet;
use std::fs;

const MANIFEST: &str = r#"
name = "gas"
replicates = 4
[model.gas]
particles = 1
duration_s = 1.0
[record]
frames = 1
channels = ["state", "pressure"]
[[checks]]
metric = "pressure.ideal_gas"
expected = 10.0
tolerance = 2.0
[[checks]]
metric = "pressure.mean_square_formula"
maximum = 1.0
"#;

/// Ideal-gas pressure `center` + 0, 1, 2, 3 by replicate: mean center + 1.5, standard error sqrt(5/3)/2 = 0.645.
fn frames(center: f64) -> impl Fn(&RunManifest) -> Frames {
    move |run| {
        two_frames(&GasPressure {
            ideal_gas_n_per_m: center + f64::from(run.replicate),
            mean_square_formula_n_per_m: 2.0,
            ..GasPressure::default()
        })
    }
}

#[test]
fn junit_and_github_report_failed_checks() {
    let folder = Folder::write(MANIFEST, frames(9.0));
    fs::write(folder.file(3), "no recording, but <&> \"this\"").unwrap();
    let file = folder.path().join("verdicts.xml");
    let output =
        analyze(&["--github-annotations", "--junit", file.to_str().unwrap(), folder.name()])
            .exited_with(3);
    let annotation = "::error file=synthetic.toml,line=14,title=gas%3A pressure.mean_square_formula::measured 2 N/m, expected at most 1";
    assert!(output.text.contains(annotation), "{}", output.text);
    assert!(
        output.text.contains("::error file=synthetic.toml,line=1,title=gas%3A unreadable::"),
        "{}",
        output.text
    );
    let xml = fs::read_to_string(file).unwrap();
    assert!(
        xml.contains("<testsuite name=\"gas\" tests=\"6\" failures=\"1\" errors=\"1\" time="),
        "{xml}"
    );
    assert!(
        xml.contains(
            "name=\"pressure.ideal_gas: within 2 of 10\" time=\"0.000\"><system-out>measured 10 N/m"
        ),
        "{xml}"
    );
    let names: Vec<&str> = xml.lines().filter_map(|line| line.split(" name=").nth(1)).collect();
    assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "each name once: {xml}");
    assert!(xml.contains("<failure message=\"measured 2 N/m, expected at most 1\"/>"), "{xml}");
    // The file is well-formed: every open tag is closed, and every ampersand is escaped.
    assert_eq!(xml.matches("<testcase").count(), xml.matches("</testcase>").count());
    assert!(
        !xml.replace("&amp;", "")
            .replace("&lt;", "")
            .replace("&gt;", "")
            .replace("&quot;", "")
            .replace("&#", "")
            .contains('&')
    );
}

/// A recording with changed bytes and an unchanged modification time is not read again until it is touched or
/// --no-cache is given. Therefore, the numbers came from the cache.
#[test]
fn unchanged_recording_is_not_read_again() {
    let quiet = MANIFEST.split("[[checks]]").next().unwrap();
    let folder = Folder::write(quiet, frames(10.0));
    folder.metrics();
    let first = fs::read(folder.path().join("metrics.json")).unwrap();
    let report = fs::read(folder.path().join("report.html")).unwrap();
    let recording = folder.file(0);
    let changed = fs::metadata(&recording).unwrap().modified().unwrap();
    let mut bytes = fs::read(&recording).unwrap();
    let middle = bytes.len() * 2 / 3;
    let whole = bytes.clone();
    // The damage is after the manifest, so that the file opens, but its frames cannot be read.
    let frames_end = whole.windows(8).rposition(|window| window == b"outcome\0").unwrap_or(middle);
    bytes[frames_end.min(middle)] ^= 0xff;
    fs::write(&recording, &bytes).unwrap();
    fs::File::options().write(true).open(&recording).unwrap().set_modified(changed).unwrap();
    analyze(&[folder.name()]).exited_with(0);
    assert!(first == fs::read(folder.path().join("metrics.json")).unwrap());
    assert!(report == fs::read(folder.path().join("report.html")).unwrap());
    assert_eq!(analyze(&["--no-cache", folder.name()]).code, 5);
    fs::write(&recording, &whole).unwrap();
    assert_eq!(analyze(&[folder.name()]).code, 0);
    assert!(first == fs::read(folder.path().join("metrics.json")).unwrap());
}

/// The analysis of a folder needs only the cache that the tasks wrote for their recordings; the frames may be
/// unreadable. It gives the same bytes as an analysis that reads the frames.
#[test]
fn cached_analyses_of_tasks_are_combined_without_the_frames() {
    let quiet = MANIFEST.split("[[checks]]").next().unwrap();
    let read = Folder::write(quiet, frames(10.0));
    assert_eq!(analyze(&[read.name()]).code, 0);
    let folder = Folder::write(quiet, frames(10.0));
    for index in 0..folder.files.len() {
        let file = folder.file(index);
        assert_eq!(analyze(&["--cache-only", file.to_str().unwrap()]).code, 0);
        let changed = fs::metadata(&file).unwrap().modified().unwrap();
        let mut bytes = fs::read(&file).unwrap();
        let middle = bytes.len() * 2 / 3;
        let outcome = bytes.windows(8).rposition(|window| window == b"outcome\0");
        bytes[outcome.unwrap_or(middle).min(middle)] ^= 0xff;
        fs::write(&file, &bytes).unwrap();
        fs::File::options().write(true).open(&file).unwrap().set_modified(changed).unwrap();
    }
    assert!(!folder.path().join("metrics.json").exists());
    assert_eq!(analyze(&[folder.name()]).code, 0);
    for file in ["metrics.json", "metrics.csv", "report.html"] {
        let of = |folder: &Folder| fs::read(folder.path().join(file)).unwrap();
        assert!(of(&folder) == of(&read), "{file}");
    }
    assert_eq!(analyze(&["--no-cache", folder.name()]).code, 5);
}
