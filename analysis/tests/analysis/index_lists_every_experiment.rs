//! Guarantee: the analysis of a folder of experiments writes `index.html`, which names each experiment with its question and result and links
//! its report. Text from recordings is no markup. A page that the user wrote is not replaced. `--open` opens the page in the browser.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]
#![cfg(unix)]

use crate::synthetic::{Folder, Frames, analyze, two_frames};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::GasPressure;
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

fn manifest(name: &str, question: &str, expected: f64) -> String {
    format!(
        "# {question}\nname = \"{name}\"\ndescription = \"{question}\"\n[model.gas]\nparticles = 1\nduration_s = 1.0\n[record]\nframes = 1\nchannels = [\"state\", \"pressure\"]\n[[checks]]\nmetric = \"pressure.measured\"\nexpected = {expected:?}\ntolerance = 0.5\n"
    )
}

fn frames(_: &RunManifest) -> Frames {
    two_frames(&GasPressure { measured_since_start_n_per_m: 100.0, ..GasPressure::default() })
}

/// A folder with experiments in the subfolders `plain`, which passes its check, and `a b#c`, which fails.
fn two_experiments() -> TempDir {
    let all = TempDir::new().unwrap();
    let experiments =
        [("plain", "plain", "Is 1 < 2?", 100.0), ("a b#c", "other", "<b>bold</b> & more?", 7.0)];
    for (subfolder, name, question, expected) in experiments {
        let folder = Folder::write(&manifest(name, question, expected), frames);
        let target = all.path().join(subfolder);
        fs::create_dir(&target).unwrap();
        for entry in fs::read_dir(folder.path()).unwrap() {
            let entry = entry.unwrap();
            fs::copy(entry.path(), target.join(entry.file_name())).unwrap();
        }
    }
    all
}

fn index(folder: &Path) -> String {
    fs::read_to_string(folder.join("index.html")).unwrap()
}

#[test]
fn index_names_question_result_and_report_of_each_experiment() {
    let all = two_experiments();
    let output = analyze(&[all.path().to_str().unwrap()]).exited_with(3);
    assert!(output.text.contains("index.html"), "{}", output.text);
    let page = index(all.path());
    for part in [
        "2 experiments, 1 with failures",
        "href=\"./plain/report.html\"",
        "href=\"./a%20b%23c/report.html\"",
        "Is 1 &lt; 2?",
        "&lt;b&gt;bold&lt;/b&gt; &amp; more?",
        "the check passes",
        "the check failed",
    ] {
        assert!(page.contains(part), "{part} is missing in {page}");
    }
    // The same recordings give the same page.
    analyze(&[all.path().to_str().unwrap()]);
    assert_eq!(index(all.path()), page);
}

#[test]
fn a_single_experiment_has_no_index() {
    let all = two_experiments();
    let one = all.path().join("plain");
    assert_eq!(analyze(&[one.to_str().unwrap()]).code, 0);
    assert!(!one.join("index.html").exists() && !all.path().join("index.html").exists());
}

#[test]
fn results_in_another_folder_have_their_index_there() {
    let (all, results) = (two_experiments(), TempDir::new().unwrap());
    let output = results.path().to_str().unwrap();
    assert_eq!(analyze(&["--output", output, all.path().to_str().unwrap()]).code, 3);
    assert!(index(results.path()).contains("href=\"./other/report.html\""));
    assert!(!all.path().join("index.html").exists());
}

#[test]
fn a_page_of_the_user_is_not_replaced() {
    let all = two_experiments();
    fs::write(all.path().join("index.html"), "my own page").unwrap();
    let output = analyze(&[all.path().to_str().unwrap()]);
    assert!(output.text.contains("is not replaced"), "{}", output.text);
    assert_eq!(index(all.path()), "my own page");
}

#[test]
fn open_shows_the_page_in_the_browser() {
    let (all, programs) = (two_experiments(), TempDir::new().unwrap());
    let opened = programs.path().join("opened");
    let browser = programs.path().join("xdg-open");
    // The name appears as a whole.
    let script =
        format!("#!/bin/sh\necho \"$1\" > '{0}.new' && mv '{0}.new' '{0}'\n", opened.display());
    fs::write(&browser, script).unwrap();
    fs::set_permissions(&browser, fs::Permissions::from_mode(0o755)).unwrap();
    let path = std::env::var("PATH").unwrap();
    for (input, page) in
        [(all.path().join("plain"), "plain/report.html"), (all.path().to_path_buf(), "index.html")]
    {
        let status = Command::new(env!("CARGO_BIN_EXE_analyze-recordings"))
            .args(["--quiet", "--open"])
            .arg(&input)
            .env("PATH", format!("{}:{path}", programs.path().display()))
            .status()
            .unwrap();
        assert!(status.code().is_some_and(|code| code != 2));
        while !opened.exists() {
            std::thread::yield_now();
        }
        let shown = fs::read_to_string(&opened).unwrap();
        assert_eq!(Path::new(shown.trim()), all.path().canonicalize().unwrap().join(page));
        fs::remove_file(&opened).unwrap();
    }
}

#[test]
fn without_a_browser_the_user_learns_the_file() {
    let all = two_experiments();
    let output = Command::new(env!("CARGO_BIN_EXE_analyze-recordings"))
        .args(["--quiet", "--open"])
        .arg(all.path().join("plain"))
        .env("PATH", "/nonexistent")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("report.html"), "{errors}");
}

/// The results of the second one would replace those of the first.
#[test]
fn experiments_of_one_name_have_no_common_folder_of_results() {
    let all = two_experiments();
    let results = TempDir::new().unwrap();
    let below = all.path().join("again");
    fs::create_dir(&below).unwrap();
    for entry in fs::read_dir(all.path().join("plain")).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), below.join(entry.file_name())).unwrap();
    }
    let output =
        analyze(&[all.path().to_str().unwrap(), "--output", results.path().to_str().unwrap()])
            .exited_with(2);
    assert!(output.text.contains("have the same name"), "{}", output.text);
    assert_eq!(fs::read_dir(results.path()).unwrap().count(), 0);
}

/// A single file of a program without the engine cannot be verified in a browser, which the page and the command say. Control: pages that
/// load the engine from a file next to them.
#[test]
fn single_file_without_the_engine_is_announced() {
    let all = two_experiments();
    let plain = all.path().join("plain");
    let folder = plain.to_str().unwrap();
    let note = "without the engine";
    let text = |arguments: &[&str]| {
        let text = analyze(&[arguments, &[folder]].concat()).exited_with(0).text;
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let single = text(&["--single-file"]);
    let page = fs::read_to_string(plain.join("report.html")).unwrap();
    assert_eq!(single.contains(note), page.contains(note), "{single}");
    assert!(!text(&[]).contains(note));
}
