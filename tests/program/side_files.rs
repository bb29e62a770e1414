//! Guarantee: a manifest or a file next to recordings that is as large as its kind may be takes bounded memory and time, whatever
//! it contains: a TOML text can take 80 times its size in memory, and each of its errors more.
//!
//! Setup: 1.5 GiB of address space, most of which threads reserve and do not use. Control: without the limit of words and signs,
//! the side file of numbers takes 4.6 GB.

#![cfg(target_os = "linux")]

use crate::subcommand_bench::{Bench, Called};
use std::fs;
use std::process::Command;

const ADDRESS_SPACE_KIB: u64 = 1_500_000;

fn call(bench: &Bench, arguments: &[&str]) -> Called {
    Command::new("timeout")
        .args(["--kill-after=5", "300", "sh", "-c"])
        .arg(format!("ulimit -v {ADDRESS_SPACE_KIB}; exec \"$0\" \"$@\""))
        .arg(env!("CARGO_BIN_EXE_kinetoscope"))
        .args(arguments)
        .current_dir(bench.path("."))
        .output()
        .unwrap()
        .into()
}

fn assert_error(called: &Called, code: i32, what: &str, case: &str) {
    let text = format!("{}{}", called.out, called.err);
    assert_eq!(called.code, Some(code), "{case}: {text}");
    assert!(text.split_whitespace().collect::<Vec<_>>().join(" ").contains(what), "{case}: {text}");
    assert!(text.len() < 100_000, "{case}: {} bytes of output", text.len());
}

/// A text of about `bytes` bytes: a beginning, then a part repeated.
fn repeated(beginning: &str, part: &str, bytes: usize) -> String {
    beginning.to_owned() + &part.repeat((bytes - beginning.len()) / part.len())
}

const EXCESS: &str = "more than 8388608 words and signs";

#[test]
fn side_file_of_numbers_is_rejected_before_it_is_parsed() {
    let bench = Bench::new();
    let recording = bench.recording();
    let folder = recording.parent().unwrap();
    let text = repeated("name = \"gas\"\nmodel = \"gas\"\nlist = [", "1,", 60_000_000) + "]\n";
    fs::write(folder.join("experiment.toml"), &text).unwrap();
    assert_eq!(call(&bench, &["info", recording.to_str().unwrap()]).code, Some(0));
    let analyzed = call(&bench, &["analyze", folder.to_str().unwrap()]);
    assert_error(&analyzed, 5, EXCESS, "analyze");
    bench.write("kinetoscope.lock", &format!("version = 1\n{text}"));
    assert_error(&call(&bench, &["check", "--locked"]), 5, EXCESS, "check --locked");
    assert_error(&call(&bench, &["lock", "gas.toml"]), 5, EXCESS, "lock");
    // The next start replaces the side file.
    assert_eq!(call(&bench, &["run", "--quiet", "gas.toml"]).code, Some(0));
    assert_eq!(call(&bench, &["analyze", folder.to_str().unwrap()]).code, Some(0));
}

/// The side file of the largest sweep is read: 100,000 runs with two swept keys.
#[test]
fn side_file_of_a_hundred_thousand_runs_is_read() {
    let bench = Bench::new();
    let recording = bench.recording();
    let folder = recording.parent().unwrap();
    let name = recording.file_name().unwrap().to_str().unwrap();
    let mut text = fs::read_to_string(folder.join("experiment.toml")).unwrap();
    assert!(text.contains(name), "{text}");
    for run in 1..100_000 {
        text += &format!(
            "\n[[runs]]\nfile = \"gas__{run:08x}.mcap\"\nrun_key = \"{run:064x}\"\ncoordinates = [[\"model.gas.particles\", \"{run}\"], \
             [\"model.gas.temperature_k\", \"{run}.5\"]]\nreplicate = 0\n"
        );
    }
    fs::write(folder.join("experiment.toml"), text).unwrap();
    let analyzed = call(&bench, &["analyze", "--no-replay", folder.to_str().unwrap()]);
    assert_error(&analyzed, 0, "99999 of 100000 runs have no finished recording yet", "analyze");
}

#[test]
fn manifests_of_errors_alone_take_bounded_memory_and_time() {
    let bench = Bench::new();
    let recording = bench.recording();
    let recording = recording.to_str().unwrap();
    for (case, beginning, part, what) in [
        ("signs", "", "=", EXCESS),
        ("signs in lines", "", "= 123456789\n", "this is not TOML"),
        ("open lists", "a = ", "[", EXCESS),
        ("numbers", "a = [", "1,", EXCESS),
        ("nested tables", "a", ".a", EXCESS),
        ("empty lines", "", " \n", EXCESS),
    ] {
        bench.write("large.toml", &repeated(beginning, part, 15_000_000));
        assert_error(&call(&bench, &["check", "large.toml"]), 2, what, case);
    }
    // A list that does not end.
    bench.write("large.toml", &repeated("a = [", "123456,", 4_000_000));
    for arguments in [
        &["check", "large.toml"][..],
        &["why", "large.toml"],
        &["analyze", "--checks", "large.toml", recording],
    ] {
        assert_error(&call(&bench, arguments), 2, "this is not TOML", &format!("{arguments:?}"));
    }
    bench.write("large.toml", &repeated("", "=", 30_000));
    assert_error(&call(&bench, &["check", "large.toml"]), 2, "this is not TOML", "a small text");
}

/// All errors of a text of at most a mebibyte are examined.
#[test]
#[ignore = "takes 30 s: a million errors"]
fn manifest_of_a_million_errors_takes_bounded_memory() {
    let bench = Bench::new();
    bench.write("large.toml", &repeated("", "=", 1_000_000));
    assert_error(&call(&bench, &["check", "large.toml"]), 2, "this is not TOML", "a mebibyte");
}

/// Files that are read as JSON: a baseline, the timing table, the host file.
#[test]
fn large_json_files_take_bounded_memory() {
    let bench = Bench::new();
    let recording = bench.recording();
    let folder = recording.parent().unwrap().to_str().unwrap().to_owned();
    let text = repeated("[", "[],", 16_000_000) + "1]";
    let stem = recording.file_stem().unwrap().to_str().unwrap();
    for name in ["timing.json", "metrics.json", &format!("{stem}.host.json")] {
        bench.write(&format!("recordings/gas/{name}"), &text);
    }
    bench.write("baseline.json", &text);
    let analyzed = call(&bench, &["analyze", &folder]);
    assert_error(&analyzed, 0, "timing.json is no timing table", "the timing table");
    let compared = call(&bench, &["analyze", "--baseline", "baseline.json", &folder]);
    assert_error(&compared, 2, "baseline.json", "a baseline");
}
