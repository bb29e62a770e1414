//! Guarantee: the last message of a run names a command that works in the same installation. A meaningless count is answered with an
//! allowed one. The help text contains no identifier of the source code.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;
use std::process::Command;

const PROGRAM: &str = env!("CARGO_BIN_EXE_run-experiment");

/// The output of `program` on both streams for these arguments.
fn output_of(program: &Path, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    out + &err
}

#[test]
fn next_command_belongs_to_the_same_installation() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("short.toml");
    fs::write(&manifest, "[model.orbit]\nduration_days = 1.0\n[record]\nframes = 1\n").unwrap();
    let output = folder.path().join("my recordings");
    let arguments = [manifest.to_str().unwrap(), "--output", output.to_str().unwrap()];
    let place = format!("'{}'", output.join("short").display());
    // In Cargo's folder `target`, the other program may not have been built.
    let by_cargo = output_of(Path::new(PROGRAM), &arguments);
    let next = format!("cargo run --release --bin analyze-recordings -- {place}");
    assert!(by_cargo.contains(&next), "{by_cargo}");
    let installed = folder.path().join("run-experiment");
    fs::copy(PROGRAM, &installed).unwrap();
    let by_path = output_of(&installed, &arguments);
    let next = format!("{} {place}", folder.path().join("analyze-recordings").display());
    assert!(by_path.contains(&next), "{by_path}");
}

#[test]
fn name_of_an_example_that_is_no_file_has_the_command_that_writes_it() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("first_run");
    let answer = output_of(Path::new(PROGRAM), &[missing.to_str().unwrap()]);
    assert!(answer.contains("`kinetoscope new first_run --output first_run.toml`"), "{answer}");
}

/// A link `run-experiment` to the program, without and with a link `analyze-recordings` next to it: the command that is printed can be
/// executed.
#[cfg(unix)]
#[test]
fn next_command_of_a_lone_link_exists() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().canonicalize().unwrap();
    let manifest = folder.join("short.toml");
    fs::write(&manifest, "[model.orbit]\nduration_days = 1.0\n[record]\nframes = 1\n").unwrap();
    let output = folder.join("out");
    let arguments = [manifest.to_str().unwrap(), "--output", output.to_str().unwrap()];
    let [program, links] = [folder.join("kinetoscope"), folder.join("bin")];
    fs::copy(PROGRAM, &program).unwrap();
    fs::create_dir(&links).unwrap();
    symlink(&program, links.join("run-experiment")).unwrap();
    let next_command = || {
        let called = output_of(&links.join("run-experiment"), &arguments);
        let (_, next) = called.split_once("\nNext:\n").unwrap_or_else(|| panic!("{called}"));
        next.trim().lines().next().unwrap_or_default().to_owned()
    };
    let lone = next_command();
    let place = output.join("short");
    assert_eq!(lone, format!("{} analyze {}", program.display(), place.display()));
    assert!(Command::new("sh").args(["-c", &lone]).output().unwrap().status.success(), "{lone}");
    symlink(&program, links.join("analyze-recordings")).unwrap();
    let analysis = links.join("analyze-recordings");
    assert_eq!(next_command(), format!("{} {}", analysis.display(), place.display()));
}

#[test]
fn invalid_counts_are_rejected_with_the_allowed_range() {
    for option in ["--jobs", "--threads", "--runs-per-task", "--time-limit"] {
        for count in ["0", "many", "-1"] {
            let argument = format!("{option}={count}");
            let answer = output_of(Path::new(PROGRAM), &["none.toml", &argument]);
            assert!(answer.contains("write a whole number from 1"), "{argument}: {answer}");
        }
    }
}

#[test]
fn help_contains_no_identifier() {
    let help = output_of(Path::new(PROGRAM), &["--help"]);
    assert!(help.contains("Exit codes:"), "{help}");
    assert!(!help.contains("[`") && !help.contains("::"), "{help}");
}
