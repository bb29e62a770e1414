//! Guarantee: one program under three names. `run-experiment` and `analyze-recordings` are `kinetoscope run` and
//! `kinetoscope analyze`, as binaries, as links and as copies, by any path; under any other name, the program is `kinetoscope`.

#![cfg(unix)]

use crate::subcommand_bench::{Bench, Called, GAS, recordings};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// Every binary that cargo builds: the name of the call decides, not the file.
const BINARIES: [&str; 3] = [
    env!("CARGO_BIN_EXE_kinetoscope"),
    env!("CARGO_BIN_EXE_run-experiment"),
    env!("CARGO_BIN_EXE_analyze-recordings"),
];

fn called(bench: &Bench, program: &str, arguments: &[&str]) -> Called {
    let mut command = Command::new(program);
    command.current_dir(bench.path("")).args(arguments).output().unwrap().into()
}

#[test]
fn link_does_what_its_name_says() {
    for (index, binary) in BINARIES.into_iter().enumerate() {
        let bench = Bench::new();
        bench.write("gas.toml", GAS);
        for name in ["kinetoscope", "run-experiment", "analyze-recordings", "unknown"] {
            symlink(binary, bench.path(name)).unwrap();
        }
        let absolute = |name: &str| bench.path(name).to_str().unwrap().to_owned();
        let ran = called(&bench, &absolute("run-experiment"), &["--quiet", "gas.toml"]);
        assert_eq!(ran.code, Some(0), "{binary}: {}", ran.err);
        let recording = recordings(&bench.path("recordings/gas")).remove(0);
        let analyzed = called(&bench, "./analyze-recordings", &["--quiet", "recordings/gas"]);
        assert_eq!(analyzed.code, Some(0), "{binary}: {}", analyzed.err);
        assert!(bench.path("recordings/gas/report.html").exists());
        let recording = recording.to_str().unwrap();
        for name in ["./kinetoscope", "./unknown"] {
            let info = called(&bench, name, &["info", recording]);
            assert_eq!(info.code, Some(0), "{binary} as {name}: {}", info.err);
            let run = called(&bench, name, &["run", "--quiet", "gas.toml"]);
            assert_eq!(run.code, Some(0), "{binary} as {name}: {}", run.err);
        }
        // Control: the names are distinguished.
        let control = called(&bench, "./run-experiment", &["info", recording]);
        assert_eq!(control.code, Some(2), "{index}: {}", control.out);
    }
}

#[test]
fn version_and_help_state_the_name() {
    for binary in BINARIES {
        let name = Path::new(binary).file_name().unwrap().to_str().unwrap();
        let bench = Bench::new();
        let version = called(&bench, binary, &["--version"]);
        assert!(version.out.starts_with(&format!("{name} ")), "{}", version.out);
        let help = called(&bench, binary, &["--help"]);
        assert!(help.out.contains(&format!("Usage: {name} ")), "{}", help.out);
    }
}

/// The path of a program that was called by a link is that of its target, which has another name.
#[test]
fn exported_commands_of_a_link_run() {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    symlink(BINARIES[0], bench.path("run-experiment")).unwrap();
    let exported = called(&bench, "./run-experiment", &["--export-commands", "list", "gas.toml"]);
    assert_eq!(exported.code, Some(0), "{}", exported.err);
    let ran = called(&bench, "sh", &["list"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert_eq!(recordings(&bench.path("recordings/gas")).len(), 1);
}
