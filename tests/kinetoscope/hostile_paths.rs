//! Guarantee: a path reaches the terminal and CI systems within one line and without control characters, whether it was given on
//! the command line or found in a folder.
//!
//! Setup: every command that names a path, on folders whose names contain a line feed and a workflow command, or an escape
//! sequence of a terminal. Control: a message that contains such a name unescaped is rejected by the same assertion.

#![cfg(unix)]

use super::{Bench, Called, GAS};
use std::fs;

const FOLDERS: [&str; 2] = ["a\n::error::b", "\u{1b}[31m\r\u{202e}c"];

fn is_hostile(character: char) -> bool {
    character.is_control() && !matches!(character, '\n' | '\t') || character == '\u{202e}'
}

/// The first line that a hostile name began, or that has a control character.
fn hostile_line(text: &str) -> Option<&str> {
    text.split('\n').find(|line| {
        // The name of the folder is broken where its line feed is a line feed.
        line.contains(is_hostile) || line.trim_start().trim_start_matches('\\').starts_with("::")
    })
}

fn assert_safe(called: &Called, code: i32, case: &str) {
    for text in [&called.out, &called.err] {
        assert_eq!(hostile_line(text), None, "{case}: {text}");
    }
    assert_eq!(called.code, Some(code), "{case}: {}{}", called.out, called.err);
}

#[test]
fn paths_are_escaped_in_every_command() {
    for folder in FOLDERS {
        let bench = Bench::new();
        fs::create_dir(bench.path(folder)).unwrap();
        let at = |name: &str| format!("{folder}/{name}");
        let (manifest, output, recordings) = (at("gas.toml"), at("out"), at("out/gas"));
        bench.write(&manifest, GAS);
        bench.write(
            &at("keyframes.toml"),
            &(GAS.to_owned() + "keep = \"keyframes\"\nkeyframe_distance = 2\n"),
        );
        bench.write(&at("broken.toml"), "seed = \n[model.gas]\nparticels = 2\n");
        bench.write(&at("not.mcap"), "junk");
        fs::create_dir(bench.path(&at("empty"))).unwrap();
        bench.write(
            &at("checks.toml"),
            "[[checks]]\nmetric = \"energy.kinetic\"\nminimum = 1e300\n",
        );
        let start = "seed = 1\n[model.gas]\nstart_from = \"none.toml\"\nduration_s = 0.001\n";
        bench.write(&at("start.toml"), start);
        let run = |arguments: &[&str], code: i32| {
            let called = bench.call(arguments);
            assert_safe(&called, code, &format!("{arguments:?}"));
            called
        };
        run(&["run", "--output", &output, &manifest], 0);
        run(&["run", "--output", &output, &manifest], 0);
        run(&["run", "--verbose", "--force", "--output", &output, &at("keyframes.toml")], 0);
        let found = |experiment: &str| {
            let path = super::recordings(&bench.path(&at(experiment))).remove(0);
            at(&format!("{experiment}/{}", path.file_name().unwrap().to_str().unwrap()))
        };
        let (recording, keyframes) = (found("out/gas"), found("out/keyframes"));
        let (broken, junk, missing) = (at("broken.toml"), at("not.mcap"), at("missing"));
        let lock = at("k.lock");
        for (arguments, code) in [
            (&["run", "--dry-run", "--output", &output, &manifest][..], 0),
            (&["run", &broken], 2),
            (&["run", &missing], 2),
            (&["run", &junk], 2),
            (&["run", &at("start.toml")], 2),
            (&["run", "--output", &junk, &manifest], 75),
            (&["run", "--prune", "--output", &output, &manifest], 0),
            (
                &[
                    "run",
                    "--export-commands",
                    &missing,
                    "--force",
                    "--output",
                    "elsewhere",
                    &manifest,
                ],
                2,
            ),
            (&["run", "--gnuplot", &at("plot"), "--force", "--output", &output, &manifest], 0),
            (&["run", "--gnuplot", &junk, "--force", "--output", &output, &manifest], 75),
            (&["check", "--output", &output, &manifest], 0),
            (&["check", "--json", "--output", &output, &manifest], 0),
            (&["check", &broken], 2),
            (&["check", "--locked", "--lock-file", &missing], 5),
            (&["why", "--output", &output, &manifest], 0),
            (&["why", &broken], 2),
            (&["benchmark", "--output", &output, &manifest], 0),
            (&["info", &recording], 0),
            (&["info", "--json", &recording], 0),
            (&["info", &junk], 5),
            (&["info", &missing], 5),
            (&["info", folder], 5),
            (&["verify", &recording], 0),
            (&["verify", "--check-attestation", &recording], 0),
            (&["verify", &junk], 5),
            (&["verify", &missing], 5),
            (&["compare", &recording, &recording], 0),
            (&["compare", &recording, &keyframes], 4),
            (&["compare", &recording, &missing], 5),
            (&["compare", "--mcap", &at("both.mcap"), &recording, &recording], 0),
            (&["compare", "--mcap", &at("both.mcap"), &recording, &recording], 2),
            (&["fill", "--output", &at("filled.mcap"), &keyframes], 0),
            (&["fill", "--output", &at("filled.mcap"), &keyframes], 0),
            (&["fill", &junk], 5),
            (&["zoom", &missing, "--from", "0", "--to", "1", "--every", "1"], 5),
            (&["analyze", &recordings], 0),
            (&["analyze", &junk], 5),
            (&["analyze", &missing], 2),
            (&["analyze", "--json", &recordings], 0),
            (&["analyze", "--checks", &broken, &recordings], 2),
            (
                &[
                    "analyze",
                    "--checks",
                    &at("checks.toml"),
                    "--junit",
                    &at("junit.xml"),
                    &recordings,
                ],
                3,
            ),
            (&["analyze", "--baseline", &junk, &recordings], 2),
            (&["export", "--format", "csv", &recordings], 0),
            (&["export", "--thumbnail", &at("picture.png"), &recording], 0),
            (&["export", "--thumbnail", &at("none/picture.png"), &recording], 75),
            (&["plot", &recordings, "--y", "/energy.kinetic_j", "--output", &at("plot.svg")], 0),
            (&["plot", &junk, "--y", "/energy.kinetic_j"], 5),
            (&["plot", &missing, "--y", "/energy.kinetic_j"], 2),
            (&["view", &missing], 5),
            (&["view", &at("empty")], 5),
            (&["lock", "--lock-file", &lock, &manifest], 0),
            (&["check", "--locked", "--lock-file", &lock], 0),
            (&["lock", "--lock-file", &junk, &manifest], 5),
            (&["lock", "--lock-file", &lock, &broken], 2),
        ] {
            run(arguments, code);
        }
        // A path that is no argument: the annotation names the file of the check in one line.
        let called = bench.call(&[
            "analyze",
            "--quiet",
            "--github-annotations",
            "--checks",
            &at("checks.toml"),
            &recordings,
        ]);
        let lines: Vec<&str> = called.out.lines().collect();
        assert!(lines.len() == 1 && lines[0].starts_with("::error file="), "{}", called.out);
        assert!(!called.out.contains(is_hostile), "{}", called.out);
    }
}

/// A command to copy keeps its meaning: a shell that reads it opens the same file.
#[test]
fn command_to_copy_names_the_same_path() {
    let bench = Bench::new();
    let folder = FOLDERS[0];
    fs::create_dir(bench.path(folder)).unwrap();
    bench.write("gas.toml", GAS);
    let called = bench.call(&["run", "--output", folder, "gas.toml"]);
    assert_safe(&called, 0, "run");
    let next = called.out.lines().last().unwrap();
    assert!(next.ends_with(r" $'a\n::error::b/gas'"), "{next}");
}

#[test]
fn control_unescaped_names_are_found() {
    for folder in FOLDERS {
        assert!(hostile_line(&format!("error: cannot read {folder}/gas.toml")).is_some());
        assert!(hostile_line(&format!("error: cannot read {folder:?}/gas.toml")).is_none());
    }
}
