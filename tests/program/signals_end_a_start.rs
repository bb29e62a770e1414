//! Guarantee: the first signal ends a command also while it builds a start that would take hours, with the code of the signal and the next
//! step; a command that only needs the recording of a run does not build its start.
//!
//! Setup: discs that are compressed at a rate of 1e-9. The signal is sent when the kernel reports that the program catches it.
//! Control: nothing else ends the command, which is killed after a minute and has no exit code then.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::subcommand_bench::{Bench, Called, command};
use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A manifest that starts from a run whose start would take hours.
const CONTINUED: &str = "[model.packing]\nstart_from = \"slow.toml\"\nevents_per_disc = 10\n";

const SLOW_START: &str = "seed = 1\n[model.packing]\ndiscs = 10\nplacement = \"compressed\"\ncompression_rate = 1e-9\nevents_per_disc = 10\n[record]\nframes = 10\n";
const LONGEST: Duration = Duration::from_mins(1);

/// Whether the program has a handler for SIGINT: bit 1 of `SigCgt` (`proc_pid_status(5)`).
fn catches_sigint(program: &Child) -> bool {
    let status = fs::read_to_string(format!("/proc/{}/status", program.id())).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    caught.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() & 0b10 != 0)
}

fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < LONGEST, "{what}");
        sleep(Duration::from_millis(5));
    }
}

#[test]
fn first_signal_ends_a_command_that_builds_a_start() {
    let bench = Bench::new();
    bench.write("slow.toml", SLOW_START);
    let locked = SLOW_START.replace("1e-9", "0.01");
    bench.write("slow_locked.toml", &locked);
    let lock = bench.call(&["lock", "--quiet", "--lock-file", "locked.lock", "slow_locked.toml"]);
    assert_eq!(lock.code, Some(0), "{}", lock.err);
    bench.write("slow_locked.toml", SLOW_START);
    for arguments in [
        "run slow.toml",
        "run --dry-run slow.toml",
        "check slow.toml",
        "why slow.toml",
        "benchmark slow.toml",
        "lock --lock-file new.lock slow.toml",
        "check --locked --lock-file locked.lock --all slow_locked.toml",
    ] {
        let mut program = command()
            .args(arguments.split(' '))
            .current_dir(bench.0.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        wait_until("the program does not catch SIGINT", || catches_sigint(&program));
        let sent = Command::new("kill").args(["-INT", &program.id().to_string()]).status().unwrap();
        assert!(sent.success());
        let start = Instant::now();
        while program.try_wait().unwrap().is_none() {
            if start.elapsed() > LONGEST {
                program.kill().unwrap();
            }
            sleep(Duration::from_millis(5));
        }
        let ended = program.wait_with_output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(130), "{arguments}: {said}");
        assert!(said.to_lowercase().contains("run the same command again"), "{arguments}: {said}");
    }
}

#[test]
fn start_of_a_run_that_is_only_looked_up_is_not_built() {
    let bench = Bench::new();
    bench.write("slow.toml", SLOW_START);
    bench.write("next.toml", CONTINUED);
    let program = command();
    let mut shell = Command::new("sh");
    shell.args(["-c", "ulimit -t 20; exec \"$0\" why next.toml"]).arg(program.get_program());
    let called: Called = shell.current_dir(bench.0.path()).output().unwrap().into();
    assert_eq!(called.code, Some(0), "{}", called.err);
    assert!(called.out.contains("slow.toml has no recording"), "{}", called.out);
}
