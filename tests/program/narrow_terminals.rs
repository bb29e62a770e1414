//! Guarantee: output fits into the width that `COLUMNS` states, without broken words, and wrong inputs are named for what they are.

use crate::subcommand_bench::{Bench, GAS, command};
use std::fs;

const WIDTH: usize = 60;

/// Calls a subcommand for a terminal of 60 columns; returns its output.
fn narrow(bench: &Bench, arguments: &[&str]) -> String {
    let mut command = command();
    command.current_dir(bench.path("")).args(arguments).env("COLUMNS", WIDTH.to_string());
    String::from_utf8(command.output().unwrap().stdout).unwrap()
}

#[test]
fn help_fits_the_columns() {
    let bench = Bench::new();
    for subcommand in ["run", "check", "verify", "compare", "info", "analyze", "export", "doctor"] {
        let help = narrow(&bench, &[subcommand, "--help"]);
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        for line in help.lines() {
            assert!(line.chars().count() <= WIDTH, "{subcommand}: {line}");
        }
        // The same words as in a wide terminal: none is broken.
        let wide = crate::subcommand_bench::call([subcommand, "--help"]).out;
        assert_eq!(words(&help), words(&wide), "{subcommand}");
    }
}

#[test]
fn report_fits_the_columns() {
    let bench = Bench::new();
    let recording = bench.recording();
    let recording = recording.to_str().unwrap();
    let report = narrow(&bench, &["analyze", recording]);
    let paths_are_longer = |line: &str| line.split_whitespace().any(|word| word.len() > 40);
    for line in report.lines().filter(|line| !paths_are_longer(line)) {
        assert!(line.chars().count() <= WIDTH, "{line}");
    }
}

/// Setup: replicates of a sweep, with a check that has no standard error and a long reason for each run. Control: the same texts in a wide
/// terminal have longer lines, and the words are the same.
#[test]
fn plans_and_summaries_fit_the_columns() {
    let bench = Bench::new();
    let sweep = "replicates = 2\n".to_owned()
        + GAS
        + "[sweep]\nmodel.gas.speed_distribution = [\"maxwell\", \"equal\"]\n";
    bench.write("several_temperatures_of_a_gas.toml", &sweep);
    let name = "several_temperatures_of_a_gas.toml";
    let (mut longest, mut texts) = (0, Vec::new());
    for arguments in [
        &["check", name] as &[&str],
        &["run", "--dry-run", name],
        &["run", name],
        &["check", name],
        &["why", "--set", "model.gas.particles=21", name],
        &["analyze", "recordings/several_temperatures_of_a_gas"],
    ] {
        let wide = bench.call(arguments).out;
        longest = wide.lines().map(|line| line.chars().count()).max().unwrap().max(longest);
        let text = narrow(&bench, arguments);
        let is_path = |line: &str| line.split_whitespace().any(|word| word.len() > 30);
        let is_command =
            |line: &str| line.starts_with("  cargo run ") || line.contains(" analyze ");
        for line in text.lines().filter(|line| !is_path(line) && !is_command(line)) {
            assert!(line.chars().count() <= WIDTH, "{arguments:?}: {line}");
        }
        texts.push((wide, text));
    }
    assert!(longest > WIDTH, "nothing was wrapped");
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let (wide, text) = &texts[4];
    assert!(words(wide) == words(text) && wide != text, "{wide}{text}");
}

#[test]
fn recording_given_as_a_manifest_is_named() {
    let bench = Bench::new();
    let recording = bench.recording();
    for subcommand in ["check", "run", "why", "benchmark"] {
        let called = bench.call(&[subcommand, recording.to_str().unwrap()]);
        assert_eq!(called.code, Some(2), "{subcommand}: {}", called.err);
        let expected = "is a recording, not a manifest\nhelp: `kinetoscope info`";
        assert!(called.err.contains(expected), "{subcommand}: {}", called.err);
    }
}

#[test]
fn description_of_recordings_given_as_a_manifest_is_named() {
    let bench = Bench::new();
    bench.recording();
    for path in ["recordings/gas/experiment.toml", "recordings/gas"] {
        let called = bench.call(&["run", path]);
        assert_eq!(called.code, Some(2), "{path}: {}", called.err);
        let expected = "describes recordings; it is not a manifest\nhelp: name the manifest";
        assert!(called.err.contains(expected), "{path}: {}", called.err);
    }
}

#[test]
fn snapshot_beyond_the_end_is_an_error() {
    let bench = Bench::new();
    let recording = bench.recording();
    let times = ["analyze", "--snapshots-at", "0.0005,7.0", recording.to_str().unwrap()];
    let called = bench.call(&times);
    assert_eq!(called.code, Some(2), "{}", called.err);
    let note = "error: no snapshot at t = 7 s: the recordings are from 0 to 0.001 s\nhelp: ";
    assert!(called.err.contains(note), "{}", called.err);
    assert!(!called.err.contains("0.0005"), "{}", called.err);
}

/// The plots of points that an edited manifest no longer has are removed by the next analysis, and by `--prune` with the
/// recordings; other pictures stay.
#[test]
fn plots_of_removed_runs_are_removed() {
    let bench = Bench::new();
    let sweep = |temperatures: &str| {
        bench.write(
            "gas.toml",
            &format!("{GAS}[sweep]\n\"model.gas.temperature_k\" = {temperatures}\n"),
        );
    };
    let has_plots_of = |temperature: &str| {
        let entries = fs::read_dir(bench.path("recordings/gas")).unwrap();
        let mut names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.any(|name| name.ends_with(".svg") && name.contains(temperature))
    };
    sweep("[100.0, 200.0]");
    assert_eq!(bench.call(&["run", "--quiet", "gas.toml"]).code, Some(0));
    assert_eq!(bench.call(&["analyze", "--quiet", "recordings/gas"]).code, Some(0));
    let own = bench.write("recordings/gas/own_of_200.svg", "<svg/>");
    assert!(has_plots_of("k=100") && has_plots_of("k=200"));
    sweep("[100.0, 300.0]");
    assert_eq!(bench.call(&["run", "--quiet", "gas.toml"]).code, Some(0));
    assert_eq!(bench.call(&["analyze", "--quiet", "recordings/gas"]).code, Some(0));
    assert!(has_plots_of("k=100") && !has_plots_of("k=200") && has_plots_of("k=300"));
    sweep("[100.0]");
    let called = bench.call(&["run", "--prune", "gas.toml"]);
    assert_eq!(called.code, Some(0), "{}", called.err);
    assert!(!has_plots_of("k=300") && own.exists(), "{}", called.out);
}
