//! Guarantee: a path reaches the terminal and CI systems within one line and without control characters, whether it was given on
//! the command line or found in a folder.
//!
//! Setup: every command that names a path, on folders whose names contain a line feed and a workflow command, or an escape
//! sequence of a terminal. Control: a message that contains such a name unescaped is rejected by the same assertion.

#![cfg(unix)]

use crate::subcommand_bench::{Bench, Called, GAS};
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

/// Commands and their exit codes. `@NAME` is a file of the folder with the hostile name, `@` the folder; `@RECORDING` and `@KEYFRAMES` are
/// the recordings of the first two commands.
const COMMANDS: &[(&str, i32)] = &[
    ("run --dry-run --output @out @gas.toml", 0),
    ("run @broken.toml", 2),
    ("run @missing", 2),
    ("run @not.mcap", 2),
    ("run @start.toml", 2),
    ("run --output @not.mcap @gas.toml", 2),
    ("run --prune --output @out @gas.toml", 0),
    ("run --export-commands @missing --force --output elsewhere @gas.toml", 2),
    ("run --gnuplot @plot --force --output @out @gas.toml", 0),
    ("run --gnuplot @not.mcap --force --output @out @gas.toml", 2),
    ("check --output @out @gas.toml", 0),
    ("check --json --output @out @gas.toml", 0),
    ("check @broken.toml", 2),
    ("check --locked --lock-file @missing", 5),
    ("why --output @out @gas.toml", 0),
    ("why @broken.toml", 2),
    ("benchmark --output @out @gas.toml", 0),
    ("info @RECORDING", 0),
    ("info --json @RECORDING", 0),
    ("info @not.mcap", 5),
    ("info @missing", 5),
    ("info @", 5),
    ("verify @RECORDING", 0),
    ("verify @not.mcap", 5),
    ("verify @missing", 5),
    ("compare @RECORDING @RECORDING", 0),
    ("compare @RECORDING @KEYFRAMES", 0),
    ("compare @RECORDING @missing", 5),
    ("compare --mcap @both.mcap @RECORDING @RECORDING", 0),
    ("compare --mcap @both.mcap @RECORDING @RECORDING", 2),
    ("fill --output @filled.mcap @KEYFRAMES", 0),
    ("fill --output @filled.mcap @KEYFRAMES", 0),
    ("fill @not.mcap", 5),
    ("zoom @missing --from 0 --to 1 --every 1", 5),
    ("analyze @out/gas", 0),
    ("analyze @not.mcap", 5),
    ("analyze @missing", 2),
    ("analyze --json @out/gas", 0),
    ("analyze --checks @broken.toml @out/gas", 2),
    ("analyze --checks @checks.toml --junit @junit.xml @out/gas", 3),
    ("analyze --baseline @not.mcap @out/gas", 2),
    ("export --format csv @out/gas", 0),
    ("export --thumbnail @picture.png @RECORDING", 0),
    ("export --thumbnail @none/picture.png @RECORDING", 2),
    ("plot @out/gas --y /energy.kinetic_j --output @plot.svg", 0),
    ("plot @not.mcap --y /energy.kinetic_j", 5),
    ("plot @missing --y /energy.kinetic_j", 2),
    ("view @missing", 5),
    ("view @empty", 5),
    ("lock --lock-file @k.lock @gas.toml", 0),
    ("check --locked --lock-file @k.lock", 0),
    ("lock --lock-file @not.mcap @gas.toml", 5),
    ("lock --lock-file @k.lock @broken.toml", 2),
];

/// The files of a folder with a hostile name.
fn prepare(bench: &Bench, folder: &str) {
    fs::create_dir_all(bench.path(folder).join("empty")).unwrap();
    let keyframes = GAS.to_owned() + "keep = \"keyframes\"\nkeyframe_distance = 2\n";
    let start = "seed = 1\n[model.gas]\nstart_from = \"none.toml\"\nduration_s = 0.001\n";
    for (name, text) in [
        ("gas.toml", GAS),
        ("keyframes.toml", &keyframes),
        ("broken.toml", "seed = \n[model.gas]\nparticels = 2\n"),
        ("not.mcap", "junk"),
        ("checks.toml", "[[checks]]\nmetric = \"energy.kinetic\"\nminimum = 1e300\n"),
        ("start.toml", start),
    ] {
        bench.write(&format!("{folder}/{name}"), text);
    }
}

#[test]
fn paths_are_escaped_in_every_command() {
    for folder in FOLDERS {
        let bench = Bench::new();
        prepare(&bench, folder);
        let found = |experiment: &str| {
            let output = format!("{folder}/out/{experiment}");
            let path = crate::subcommand_bench::recordings(&bench.path(&output)).remove(0);
            format!("{output}/{}", path.file_name().unwrap().to_str().unwrap())
        };
        let word = |word: &str| match word.strip_prefix('@') {
            Some("RECORDING") => found("gas"),
            Some("KEYFRAMES") => found("keyframes"),
            Some("") => folder.to_owned(),
            Some(name) => format!("{folder}/{name}"),
            None => word.to_owned(),
        };
        let call = |command: &str| {
            let words: Vec<String> = command.split(' ').map(word).collect();
            bench.call(&words.iter().map(String::as_str).collect::<Vec<_>>())
        };
        let first = [
            ("run --output @out @gas.toml", 0),
            ("run --output @out @gas.toml", 0),
            ("run --verbose --force --output @out @keyframes.toml", 0),
        ];
        for (command, code) in first.iter().chain(COMMANDS) {
            assert_safe(&call(command), *code, command);
        }
        // A path that is no argument: the annotation names the file of the check in one line.
        let called = call("analyze --quiet --github-annotations --checks @checks.toml @out/gas");
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
