//! Promise: the last words of a run name a command that works where this one did; a count that makes no sense is answered with one
//! that does; help shows no name of the code.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;
use std::process::Command;

const PROGRAM: &str = env!("CARGO_BIN_EXE_run-experiment");

/// What `program` says on both streams, with these arguments.
fn said(program: &Path, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    out + &err
}

#[test]
fn the_next_command_is_that_of_the_same_installation() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("short.toml");
    fs::write(&manifest, "[model.orbit]\nduration_days = 1.0\n[record]\nframes = 1\n").unwrap();
    let output = folder.path().join("my recordings");
    let arguments = [manifest.to_str().unwrap(), "--output", output.to_str().unwrap()];
    let place = format!("'{}'", output.join("short").display());
    // Cargo runs programs in its folder `target`, where the other one need not have been built.
    let by_cargo = said(Path::new(PROGRAM), &arguments);
    let next = format!("cargo run --release --bin analyze-recordings -- {place}");
    assert!(by_cargo.contains(&next), "{by_cargo}");
    let installed = folder.path().join("run-experiment");
    fs::copy(PROGRAM, &installed).unwrap();
    let by_path = said(&installed, &arguments);
    let next = format!("{} {place}", folder.path().join("analyze-recordings").display());
    assert!(by_path.contains(&next), "{by_path}");
}

#[test]
fn a_count_of_nothing_is_answered() {
    for option in ["--jobs", "--threads", "--runs-per-task", "--time-limit"] {
        for count in ["0", "many", "-1"] {
            let argument = format!("{option}={count}");
            let answer = said(Path::new(PROGRAM), &["none.toml", &argument]);
            assert!(answer.contains("write a whole number from 1"), "{argument}: {answer}");
        }
    }
}

#[test]
fn help_shows_no_name_of_the_code() {
    let help = said(Path::new(PROGRAM), &["--help"]);
    assert!(help.contains("Exit codes:"), "{help}");
    assert!(!help.contains("[`") && !help.contains("::"), "{help}");
}
