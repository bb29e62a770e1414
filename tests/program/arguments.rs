//! Guarantee: wrong arguments end with exit code 2, `error:` and `help:`; help and long output tolerate a closed pipe.

use crate::subcommand_bench::{Bench, GAS, call, command};
use std::process::Stdio;

const SUBCOMMANDS: [&str; 18] = [
    "run",
    "new",
    "demo",
    "check",
    "verify",
    "compare",
    "fill",
    "zoom",
    "why",
    "info",
    "benchmark",
    "analyze",
    "export",
    "plot",
    "schema",
    "completions",
    "doctor",
    "view",
];

#[test]
fn help_lists_every_subcommand_and_each_has_its_own() {
    let help = call(["--help"]);
    assert_eq!(help.code, Some(0));
    for subcommand in SUBCOMMANDS {
        let line = help.out.lines().find(|line| line.trim_start().starts_with(subcommand));
        assert!(line.is_some_and(|line| line.trim().len() > subcommand.len()), "{}", help.out);
        let own = call([subcommand, "--help"]);
        assert_eq!(own.code, Some(0), "{subcommand}: {}", own.err);
        assert!(own.out.contains("Usage: kinetoscope"), "{}", own.out);
        assert!(!own.out.contains("[`") && !own.out.contains("::"), "{}", own.out);
    }
}

#[test]
fn options_of_run_are_grouped() {
    let help = call(["run", "--help"]).out;
    for heading in ["Manifest:", "Output:", "Execution:", "Cluster:", "Live view:", "Messages:"] {
        assert!(help.lines().any(|line| line == heading), "{heading} in {help}");
    }
}

#[test]
fn misspelled_names_name_the_nearest() {
    for (arguments, expected) in [
        (
            &["verfy", "x.mcap"] as &[&str],
            "error: unknown subcommand `verfy`\nhelp: did you mean `verify`?\n",
        ),
        (&["rn", "x.toml"], "error: unknown subcommand `rn`\nhelp: did you mean `run`?\n"),
        (
            &["zzz"],
            "error: unknown subcommand `zzz`\nhelp: `kinetoscope --help` lists the subcommands\n",
        ),
        (
            &["run", "--forse", "x"],
            "error: unknown option `--forse`\nhelp: did you mean `--force`?\n",
        ),
    ] {
        let called = call(arguments);
        assert_eq!((called.code, called.err.as_str()), (Some(2), expected));
    }
}

#[test]
fn unknown_words_list_the_allowed_ones() {
    let foo = call(["new", "foo"]);
    assert_eq!(foo.code, Some(2), "{}", foo.err);
    let expected = "error: there is no model and no experiment \"foo\"\nhelp: the models are dem, gas, packing and orbit; ";
    assert!(foo.err.starts_with(expected), "{}", foo.err);
    let near = call(["new", "packin"]);
    assert!(near.err.ends_with("\nhelp: did you mean `packing`?\n"), "{}", near.err);
    let executor = call(["run", "--executor", "slrm", "x.toml"]);
    assert!(executor.err.starts_with("error: `--executor` is `slrm`; must be one of: local,"));
}

#[test]
fn help_lists_only_the_exit_codes_of_its_subcommand() {
    for (subcommand, codes) in [
        ("run", "0 1 2 70 75 129 130 143"),
        ("new", "0 2 70 75"),
        ("schema", "0 2 70 75"),
        ("completions", "0 2 70 75"),
        ("export", "0 2 5 70 75"),
        ("check", "0 1 2 4 5 70 75 129 130 143"),
        ("verify", "0 1 2 4 5 70 75 129 130 143"),
        ("compare", "0 2 4 5 70 75"),
        ("why", "0 1 2 70 75 129 130 143"),
        ("info", "0 2 5 70 75"),
        ("benchmark", "0 1 2 70 75 129 130 143"),
        ("doctor", "0 1 2 70 75"),
        ("view", "0 2 5 70 75 130 143"),
        ("analyze", "0 2 3 5 70 75"),
    ] {
        let help = call([subcommand, "--help"]).out;
        let (_, listed) = help.split_once("Exit codes:\n").unwrap();
        let code = |line: &str| line.split_whitespace().next().unwrap().parse::<u8>().ok();
        let listed: Vec<String> =
            listed.lines().filter_map(code).map(|code| code.to_string()).collect();
        assert_eq!(listed.join(" "), codes, "{subcommand}");
    }
}

#[test]
fn missing_arguments_are_errors_with_help() {
    for subcommand in ["run", "check", "verify", "compare", "why", "info", "benchmark"] {
        let called = call([subcommand]);
        assert_eq!(called.code, Some(2), "{subcommand}");
        let help = format!("\nhelp: `kinetoscope {subcommand} --help` lists the options\n");
        assert!(called.err.starts_with("error: ") && called.err.ends_with(&help), "{}", called.err);
    }
}

#[test]
fn closed_pipes_are_not_errors() {
    let bench = Bench::new();
    let manifest = bench.write("gas.toml", GAS);
    let manifest = manifest.to_str().unwrap();
    for arguments in [
        &["schema"] as &[&str],
        &["new", "dem"],
        &["analyze", "--list-metrics"],
        &["completions", "bash"],
        &["--help"],
        &["check", manifest],
        &["doctor"],
    ] {
        let mut child = command()
            .args(arguments)
            .current_dir(bench.path(""))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let ended = child.wait_with_output().unwrap();
        let err = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert!(!err.contains("panicked"), "{arguments:?}: {err}");
        assert_eq!(ended.status.code(), Some(0), "{arguments:?}: {err}");
    }
}

#[test]
fn output_has_no_color_codes_without_a_terminal() {
    let bench = Bench::new();
    bench.write("bad.toml", "[model.gas]\nparticle = 3\n");
    let called = bench.call(&["check", "bad.toml"]);
    assert_eq!(called.code, Some(2));
    assert!(called.err.contains("particle") && !called.err.contains('\u{1b}'), "{}", called.err);
}

#[test]
fn short_reports_fit_sixty_columns() {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    for arguments in [&["check", "gas.toml"] as &[&str], &["doctor"]] {
        let called = bench.call(arguments);
        let widest = called.out.lines().map(|line| line.chars().count()).max();
        assert!(widest <= Some(60), "{}", called.out);
    }
}

/// The folder is missing or is a file, or the destination is a folder: the same command fails again, so the arguments are wrong. No
/// error names a temporary file.
#[test]
fn outputs_with_a_wrong_path_are_rejected_with_it() {
    let bench = Bench::new();
    let recording = bench.recording();
    let recording = recording.to_str().unwrap();
    let plot = ["plot", recording, "--y", "/energy.kinetic_j", "--output"];
    for (command, path) in [
        (&["run", "--force", "gas.toml", "--output"][..], "gas.toml"),
        (&["run", "--force", "gas.toml", "--gnuplot"], "gas.toml"),
        (&["run", "--output", "new", "gas.toml", "--export-commands"], "no/commands"),
        (&["lock", "gas.toml", "--lock-file"], "no/k.lock"),
        (&["check", "--locked", "--summary"], "no/summary.md"),
        (&["benchmark", "gas.toml", "--output"], "gas.toml"),
        (&["compare", recording, recording, "--mcap"], "no/both.mcap"),
        (&["compare", recording, recording, "--mcap"], "gas.toml/both.mcap"),
        (&["analyze", "--quiet", recording, "--output"], "gas.toml"),
        (&["analyze", recording, "--junit"], "no/junit.xml"),
        (&["export", "--format", "csv", recording, "--output"], "gas.toml"),
        (&["export", recording, "--thumbnail"], "no/picture.png"),
        (&["export", recording, "--thumbnail"], "gas.toml/picture.png"),
        (&plot, "no/plot.svg"),
        (&["man-pages"], "gas.toml"),
    ] {
        let called = bench.call(&[command, &[path]].concat());
        assert_eq!(called.code, Some(2), "{command:?}: {}{}", called.out, called.err);
        let first = called.err.lines().next().unwrap();
        assert!(first.starts_with("error: ") && first.contains(path), "{}", called.err);
        assert!(called.err.contains("\nhelp: "), "{command:?}: {}", called.err);
        assert!(!called.err.contains(".tmp"), "{}", called.err);
    }
    let empty = bench.call(&["run", "gas.toml", "--output", ""]);
    assert_eq!(empty.err, "error: `--output` is empty\nhelp: write `--output DIR`\n");
}

/// An input that is too large or is something else: the help names what is expected.
#[test]
fn large_and_wrong_files_of_checks_name_what_is_expected() {
    let bench = Bench::new();
    let recording = bench.recording();
    bench.write("large.toml", &"#".repeat(60_000_000));
    for (option, expected) in [
        ("--checks", "help: name a TOML file of [[checks]]"),
        ("--baseline", "help: name the metrics.json"),
    ] {
        for (file, help) in
            [("large.toml", expected), (".", expected), ("no.toml", "help: check the path")]
        {
            let called = bench.call(&["analyze", option, file, recording.to_str().unwrap()]);
            assert_eq!(called.code, Some(2), "{}", called.err);
            assert!(called.err.contains(help), "{option} {file}: {}", called.err);
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn huge_numbers_of_threads_do_not_use_up_those_of_the_system() {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    for option in ["--threads", "--jobs"] {
        let called = bench.call(&["run", option, "1025", "gas.toml"]);
        assert_eq!(called.code, Some(2), "{}", called.err);
        assert!(called.err.contains("write a whole number from 1 to 1024"), "{}", called.err);
    }
    for arguments in ["check gas.toml", "run gas.toml", "analyze recordings/gas"] {
        // Memory for some hundred threads.
        let line = format!(r#"ulimit -v 2000000; exec "$0" {arguments}"#);
        let mut limited = std::process::Command::new("sh");
        limited.args(["-c", &line, env!("CARGO_BIN_EXE_kinetoscope")]);
        limited.env("RAYON_NUM_THREADS", "999999999").current_dir(bench.path(""));
        let called = limited.output().unwrap();
        let errors = String::from_utf8_lossy(&called.stderr);
        assert_eq!(called.status.code(), Some(0), "{arguments}: {errors}");
    }
}
