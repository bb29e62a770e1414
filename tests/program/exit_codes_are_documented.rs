//! Guarantee: every exit code is one of the help text, whatever the machine lacks. What another attempt may repair gives 75 and a next step.
//!
//! Setup: the program in an address space that does not suffice for its start, its threads or its run; inputs whose disk fails. Before
//! codes of their own, panics gave 101 and failed allocations signal 6, which a shell reports as 134.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::subcommand_bench::GAS;
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
    let (mut found, mut without_threads, mut without_memory) = (Vec::new(), 0, 0);
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
    // From hardly enough for the program itself, in steps of half the memory of a thread, to enough for a part of the particles.
    let near = (0..20).map(|step| loaded - 10_000 + 1_000 * step);
    let far = [30_000, 70_000, 120_000, 170_000, 270_000, 370_000].map(|further| loaded + further);
    for limit in near.chain(far) {
        // The system may not load the program, which then says nothing.
        if !limited(limit, "--version").status.success() {
            continue;
        }
        let ended = limited(limit, &run);
        let said = String::from_utf8_lossy(&ended.stderr);
        let code = ended.status.code();
        assert!(
            code.is_some_and(|code| codes.contains(&code)),
            "{code:?} with {limit} KiB: {said}"
        );
        // A thread that cannot be started is no defect of the program.
        assert!(!said.contains("internal error"), "{limit} KiB: {said}");
        if said.contains("a thread cannot be started") {
            assert_eq!(code, Some(75), "{limit} KiB: {said}");
            assert!(said.contains("\nhelp: end other programs"), "{limit} KiB: {said}");
            without_threads += 1;
        }
        if said.contains("memory allocation of") {
            assert_eq!(code, Some(70), "{limit} KiB: {said}");
            assert!(said.contains("\nhelp: if memory was missing"), "{limit} KiB: {said}");
            without_memory += 1;
        }
        found.push(code.unwrap());
    }
    assert!(without_memory > 0, "no limit leaves too little memory for the particles");
    assert!(without_threads > 0, "no limit leaves too little room for the threads");
    println!("exit codes: {found:?}");
    assert!(found.iter().any(|&code| code != 0), "every limit suffices, so nothing was tested");
}

/// Missing memory is not taken for damage of a recording, whose help would be to overwrite it.
#[test]
fn recording_is_not_damaged_by_missing_memory() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("run.toml"), GAS).unwrap();
    let program = env!("CARGO_BIN_EXE_kinetoscope");
    let ran = Command::new(program).args(["run", "run.toml"]).current_dir(folder.path()).output();
    assert!(ran.unwrap().status.success());
    let mut found = Vec::new();
    for limit in (20_000..100_000).step_by(2_000) {
        let command = format!("ulimit -v {limit}; exec '{program}' info recordings/run/*.mcap");
        let ended = Command::new("sh").args(["-c", &command]).current_dir(folder.path()).output();
        let ended = ended.unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert!(!said.contains("damaged"), "{limit} KiB: {said}");
        found.push(ended.status.code());
    }
    assert!(found.contains(&Some(0)), "no limit suffices: {found:?}");
    assert!(found.iter().any(|code| *code != Some(0)), "every limit suffices: {found:?}");
}

/// The memory of a process is a regular file whose first page cannot be read: Linux answers with EIO (`proc_pid_mem(5)`).
#[test]
fn failing_disk_under_an_input_gives_75_and_the_next_step() {
    let folder = tempfile::tempdir().unwrap();
    let called = |arguments: &str, input: &str| {
        let arguments = arguments.replace("INPUT", input);
        let program = env!("CARGO_BIN_EXE_kinetoscope");
        let ended = Command::new(program)
            .args(arguments.split(' '))
            .current_dir(folder.path())
            .output()
            .unwrap();
        (ended.status.code(), String::from_utf8(ended.stderr).unwrap())
    };
    fs::write(folder.path().join("start.toml"), "[model.gas]\nstart_from = \"failing.toml\"\n")
        .unwrap();
    fs::create_dir(folder.path().join("folder")).unwrap();
    fs::write(folder.path().join("gas.toml"), GAS).unwrap();
    let recorded = called("run --quiet gas.toml", "");
    assert_eq!(recorded.0, Some(0), "{}", recorded.1);
    let described = folder.path().join("recordings/gas/experiment.toml");
    fs::remove_file(&described).unwrap();
    std::os::unix::fs::symlink("/proc/self/mem", described).unwrap();
    std::os::unix::fs::symlink("/proc/self/mem", folder.path().join("failing.toml")).unwrap();
    std::os::unix::fs::symlink("/proc/self/mem", folder.path().join("folder/failing.mcap"))
        .unwrap();
    std::os::unix::fs::symlink("/proc/self/mem", folder.path().join("failing.mcap")).unwrap();
    let short = "[model.orbit]\nduration_days = 1.0\n[record]\nframes = 1\n";
    fs::write(folder.path().join("run.toml"), short).unwrap();
    for arguments in [
        "run INPUT",
        "check INPUT",
        "why INPUT",
        "benchmark INPUT",
        "run start.toml",
        "check --locked --lock-file INPUT",
        "analyze . --checks INPUT",
        "analyze . --baseline INPUT",
        "info failing.mcap",
        "verify failing.mcap",
        "compare failing.mcap failing.mcap",
        "fill failing.mcap",
        "zoom failing.mcap --from 0 --to 1 --every 1",
        "analyze failing.mcap",
        "analyze folder",
        "analyze --cache-only failing.mcap",
        "export --format csv failing.mcap",
        "export --thumbnail still.svg failing.mcap",
        "plot failing.mcap --y mean_speed",
        // The description of the experiment.
        "analyze recordings/gas",
        "export --format csv recordings/gas",
        "plot recordings/gas --y /energy.kinetic_j --output p.svg",
    ] {
        let (code, said) = called(arguments, "failing.toml");
        assert_eq!(code, Some(75), "{arguments}: {said}");
        assert!(said.contains("Input/output error"), "{arguments}: {said}");
        let help = "\nhelp: check the disk, then run the same command again";
        assert!(said.contains(help), "{arguments}: {said}");
    }
    for arguments in ["run INPUT", "check INPUT", "analyze . --checks INPUT"] {
        // Control: a path that is wrong stays wrong.
        for input in ["absent.toml", "/dev/null"] {
            let (code, said) = called(arguments, input);
            assert_eq!(code, Some(2), "{arguments} {input}: {said}");
        }
    }
}
