//! Guarantee: with `--analyze`, each task analyzes the recordings that it made, and the program that exports tasks none. A failed
//! analysis loses no run.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::process::Command;

const SWEEP: &str =
    "replicates = 3\n[model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 4\n";
const FAILS_BETWEEN_KEYFRAMES: &str = "seed = 1\n[model.packing]\ndiscs = 40\nrestitution = 0.5\nevents_per_disc = 2000\n\
    [record]\nframes = 40\nkeep = \"keyframes\"\nkeyframe_distance = 7\n";

#[test]
fn each_task_analyzes_its_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let run = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_run-experiment"));
        command.arg(path("sweep.toml")).arg("--output").arg(path("out")).arg("--analyze");
        command.args(more).output().unwrap()
    };
    let analyzed = || {
        let cache = path("out/sweep/.analysis-cache");
        fs::read_dir(cache).map_or(0, |entries| {
            let names = entries.map(|entry| entry.unwrap().file_name());
            names.filter(|name| name.to_string_lossy().ends_with(".numbers")).count()
        })
    };
    fs::write(path("sweep.toml"), SWEEP).unwrap();
    let list = path("commands");
    let exported = run(&["--runs-per-task", "2", "--export-commands", list.to_str().unwrap()]);
    assert!(exported.status.success());
    assert_eq!(analyzed(), 0, "the program that exports tasks must not analyze");
    let commands = fs::read_to_string(&list).unwrap();
    let after_each: Vec<usize> = commands
        .lines()
        .map(|command| {
            assert!(Command::new("sh").args(["-c", command]).status().unwrap().success());
            analyzed()
        })
        .collect();
    assert_eq!(after_each, [2, 3]);

    // A run that fails between two keyframes has no state of its end, which metrics need.
    fs::write(path("sweep.toml"), FAILS_BETWEEN_KEYFRAMES).unwrap();
    let again = run(&["--force"]);
    assert_eq!(again.status.code(), Some(1));
    let complaint = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(complaint.contains("not all recordings were analyzed"), "{complaint}");
}
