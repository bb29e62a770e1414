//! Guarantee: a new model is a set of new files and a few lines in at most five existing ones.
//!
//! Setup: the example `add_a_model` adds an oscillator to a copy of the sources. The copy is built; its program records the new
//! model's experiment, and its analysis checks the energy: semi-implicit Euler has the error (omega dt/2)/(1 - omega dt/2) = 5.26 %.
//! Control: the check would fail for an error of 4 % or 5.5 %, and the build fails if one of the lines is missing.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;
use std::process::Command;

/// Runs a command in a folder and returns what it printed.
fn succeed(command: &mut Command, folder: &Path) -> String {
    let output = command.current_dir(folder).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

#[test]
#[ignore = "builds the programs again, without optimization"]
fn new_model_changes_at_most_five_existing_files() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("copy");
    let example = ["run", "--quiet", "--example", "add_a_model", "--"];
    let printed = succeed(Command::new(env!("CARGO")).args(example).arg(&copy), root);
    let changed = printed.lines().filter(|line| line.starts_with("  ")).count();
    assert!((1..=5).contains(&changed), "{printed}");

    let target = root.join("target/unoptimized");
    let build = ["build", "--quiet", "--config", "profile.dev.opt-level=0", "--target-dir"];
    succeed(Command::new(env!("CARGO")).args(build).arg(&target), &copy);
    let program = |name: &str| Command::new(target.join("debug").join(name));
    succeed(program("run-experiment").args(["--quiet", "experiments/oscillator.toml"]), &copy);
    let analysis = succeed(program("analyze-recordings").arg("recordings/oscillator"), &copy);
    assert!(analysis.contains("ok energy.max_error_relative: measured 0.0526"), "{analysis}");
}
