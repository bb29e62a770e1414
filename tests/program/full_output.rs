//! Guarantee: text that cannot be written to standard output ends every command with exit code 75, `error:` and `help:`.

use crate::subcommand_bench::{Bench, GAS, command, recordings};
use std::fs::OpenOptions;

/// Calls a subcommand whose standard output is on a full disk; returns the exit code and the errors.
fn call_with_full_output(bench: &Bench, arguments: &[&str]) -> (Option<i32>, String) {
    let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = command();
    let called = command.current_dir(bench.path("")).args(arguments).stdout(full).output().unwrap();
    (called.status.code(), String::from_utf8(called.stderr).unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn every_command_reports_output_that_cannot_be_written() {
    let bench = Bench::new();
    let recording = bench.recording();
    let recording = recording.to_str().unwrap();
    for arguments in [
        &["schema"] as &[&str],
        &["new", "dem"],
        &["completions", "bash"],
        &["--help"],
        &["run", "--help"],
        &["--version"],
        &["doctor"],
        &["check", "gas.toml"],
        &["check", "--json", "gas.toml"],
        &["why", "gas.toml"],
        &["benchmark", "gas.toml"],
        &["info", recording],
        &["info", "--json", recording],
        &["verify", recording],
        &["compare", recording, recording],
        &["compare", "--json", recording, recording],
        &["run", "--dry-run", "gas.toml"],
        &["run", "gas.toml"],
        &["run", "--json", "gas.toml"],
        &["analyze", recording],
        &["analyze", "--json", recording],
        &["analyze", "--list-metrics"],
        &["export", "--format", "csv", recording],
        &["export", "--format", "csv", "--json", recording],
        &["export", "--thumbnail", "picture.png", recording],
    ] {
        let (code, errors) = call_with_full_output(&bench, arguments);
        assert_eq!(code, Some(75), "{arguments:?}: {errors}");
        let expected = "error: standard output cannot be written: ";
        assert!(
            errors.contains(expected) && errors.contains("\nhelp: "),
            "{arguments:?}: {errors}"
        );
    }
}

/// The runs do not depend on the terminal: they are recorded, and the exit code reports the lost text.
#[cfg(target_os = "linux")]
#[test]
fn runs_are_recorded_although_their_output_cannot_be_written() {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    let (code, errors) = call_with_full_output(&bench, &["run", "gas.toml"]);
    assert_eq!(code, Some(75), "{errors}");
    let recording = recordings(&bench.path("recordings/gas")).remove(0);
    assert_eq!(bench.call(&["info", recording.to_str().unwrap()]).code, Some(0));
}

/// Progress goes to standard error. If it cannot be written either, nothing panics.
#[cfg(target_os = "linux")]
#[test]
fn full_standard_error_does_not_stop_a_run() {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = command();
    command.current_dir(bench.path("")).args(["run", "--verbose", "gas.toml"]).stderr(full);
    assert_eq!(command.output().unwrap().status.code(), Some(0));
}
