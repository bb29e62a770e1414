//! Guarantee: every exit code is one of the help text, whatever the machine lacks.
//!
//! Setup: the program in an address space that does not suffice for its start, its threads or its run. Before codes of their own,
//! panics gave 101 and failed allocations signal 6, which a shell reports as 134.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::process::Command;

const RUN: &str = "[model.gas]\nparticles = 3000000\nduration_s = 1e-9\n[record]\nframes = 1\nchannels = [\"state\"]\n";

#[test]
fn program_without_memory_ends_with_a_documented_code() {
    let program = env!("CARGO_BIN_EXE_run-experiment");
    let help = Command::new(program).arg("--help").output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let codes = help.split("Exit codes:").nth(1).unwrap();
    let codes: Vec<i32> =
        codes.lines().filter_map(|line| line.split_whitespace().next()?.parse().ok()).collect();
    assert!(codes.contains(&70) && codes.contains(&75), "{codes:?}");
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("run.toml");
    fs::write(&manifest, RUN).unwrap();
    let mut found = Vec::new();
    let limited = |limit: u32, arguments: &str| {
        let command = format!("ulimit -v {limit}; exec '{program}' {arguments}");
        Command::new("sh").args(["-c", &command]).output().unwrap()
    };
    // KiB: what the system needs to load the program depends on the build, and the program is not asked about it.
    let mut limits = (1..).map(|number| 10_000 * number);
    let loaded = limits.find(|&limit| limited(limit, "--version").status.success()).unwrap();
    let run = format!(
        "--force --threads 2 --output '{}' '{}'",
        folder.path().join("recordings").display(),
        manifest.display()
    );
    // From hardly enough for the program itself to enough for a part of the particles.
    for further in [0, 30_000, 70_000, 120_000, 170_000, 270_000, 370_000] {
        let limit = loaded + further;
        let ended = limited(limit, &run);
        let said = String::from_utf8_lossy(&ended.stderr);
        let code = ended.status.code();
        assert!(
            code.is_some_and(|code| codes.contains(&code)),
            "{code:?} with {limit} KiB: {said}"
        );
        found.push(code.unwrap());
    }
    println!("exit codes: {found:?}");
    assert!(found.iter().any(|&code| code != 0), "every limit suffices, so nothing was tested");
}
