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
    // KiB: from hardly enough for the program itself to enough for a part of the particles.
    for limit in [30_000, 60_000, 100_000, 150_000, 200_000, 300_000, 400_000] {
        let command = format!(
            "ulimit -v {limit}; exec '{program}' --force --threads 2 --output '{}' '{}'",
            folder.path().join("recordings").display(),
            manifest.display()
        );
        let ended = Command::new("sh").args(["-c", &command]).output().unwrap();
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
