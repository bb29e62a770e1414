//! Promise: with `--analyze` a task has its recordings analyzed where they are made, by the program beside its own; an analysis
//! that fails loses no run. The analysis here is a script that writes down what it is asked.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::Command;

const SWEEP: &str =
    "replicates = 3\n[model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 4\n";

#[test]
fn each_task_hands_its_recordings_to_the_analysis() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let program = path("run-experiment");
    fs::copy(env!("CARGO_BIN_EXE_run-experiment"), &program).unwrap();
    let script = |text: &str| {
        fs::write(path("analyze-recordings"), format!("#!/bin/sh\n{text}\n")).unwrap();
        let mode = fs::Permissions::from_mode(0o755);
        fs::set_permissions(path("analyze-recordings"), mode).unwrap();
    };
    let log = path("asked");
    script(&format!("echo \"$@\" >> '{}'", log.display()));
    fs::write(path("sweep.toml"), SWEEP).unwrap();
    let run = |more: &[&str]| {
        let mut command = Command::new(&program);
        command.arg(path("sweep.toml")).arg("--output").arg(path("out")).arg("--analyze");
        command.args(more).output().unwrap()
    };
    let list = path("commands");
    let exported = run(&["--runs-per-task", "2", "--export-commands", list.to_str().unwrap()]);
    assert!(exported.status.success());
    assert!(!log.exists(), "who gives tasks analyzes nothing");
    for command in fs::read_to_string(&list).unwrap().lines() {
        assert!(Command::new("sh").args(["-c", command]).status().unwrap().success());
    }
    let asked = fs::read_to_string(&log).unwrap();
    let files: Vec<usize> = asked.lines().map(|line| line.matches(".mcap").count()).collect();
    assert!(files == [2, 1] && asked.starts_with("--cache-only "), "{asked}");

    script("exit 5");
    let again = run(&["--force"]);
    assert_eq!(again.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&again.stderr).contains("not all recordings were analyzed"));
}
