//! Guarantee: with `keep = "metrics"`, `runs.parquet` has the bytes that an analysis of all recordings writes, on any number of jobs and
//! however often the sweep was killed; `restore` writes the bytes of the recordings, and each row has the hash of their messages.
//!
//! Setup: two temperatures and two distributions of speeds with replicates of 20 particles, and discs with an unstable time step.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::subcommand_bench::{Bench, Called, command, recordings};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::Duration;

fn sweep(replicates: u32, keep: &str) -> String {
    format!(
        "name = \"gas\"\nseed = 3\nreplicates = {replicates}\n[model.gas]\nparticles = 20\nduration_s = 0.001\n\
         [record]\nframes = 4\nkeep = \"{keep}\"\n[sweep]\n\"model.gas.temperature_k\" = [200, 300]\n\
         \"model.gas.speed_distribution\" = [\"maxwell\", \"equal\"]\n"
    )
}

fn expect(called: &Called, code: i32) {
    assert_eq!(called.code, Some(code), "{}{}", called.out, called.err);
}

/// The table of a sweep whose recordings are not kept, executed below `output`.
fn table(bench: &Bench, replicates: u32, output: &str, more: &[&str]) -> Vec<u8> {
    bench.write("kept.toml", &sweep(replicates, "metrics"));
    let run = ["run", "--quiet", "kept.toml", "--output", output];
    expect(&bench.call(&[&run, more].concat()), 0);
    assert!(!bench.path(output).join("gas/.runs.journal").exists());
    fs::read(bench.path(output).join("gas/runs.parquet")).unwrap()
}

#[test]
fn table_without_recordings_has_the_bytes_of_an_analysis() {
    let bench = Bench::new();
    bench.write("all.toml", &sweep(3, "all"));
    expect(&bench.call(&["run", "--quiet", "all.toml"]), 0);
    expect(&bench.call(&["analyze", "--quiet", "recordings/gas"]), 0);
    let analyzed = fs::read(bench.path("recordings/gas/runs.parquet")).unwrap();
    assert!(table(&bench, 3, "one", &["--jobs", "1"]) == analyzed, "one job");
    assert!(table(&bench, 3, "four", &["--jobs", "4"]) == analyzed, "four jobs");
    assert_eq!(recordings(&bench.path("four/gas")).len(), 0);
    // Finished rows are not executed again, and those of more replicates are added.
    assert!(table(&bench, 3, "one", &[]) == analyzed, "again");
    assert!(bench.call(&["run", "kept.toml", "--output", "one"]).out.contains("12 runs, 0 to do"));
    let more = table(&bench, 4, "one", &[]);
    assert!(more == table(&bench, 4, "from_scratch", &[]) && more != analyzed);

    let verified = bench.call(&["verify", "one/gas"]);
    assert!(verified.err.contains("`verify --sample 100`"), "{}", verified.err);

    // Restored recordings are those that were recorded, byte for byte.
    let restore = ["restore", "one/gas", "--where", "replicate=1,temperature_k<300"];
    let restored = bench.call(&restore);
    expect(&restored, 0);
    assert!(restored.out.contains("2 of 2 runs"), "{}", restored.out);
    let files = recordings(&bench.path("one/gas/restored"));
    assert_eq!(files.len(), 2);
    for file in &files {
        let recorded = bench.path("recordings/gas").join(file.file_name().unwrap());
        assert!(fs::read(file).unwrap() == fs::read(recorded).unwrap(), "{file:?}");
    }
    let verified = bench.call(&["verify", "one/gas", "--sample", "5"]);
    expect(&verified, 0);
    assert!(verified.out.contains("5 of 5 runs"), "{}", verified.out);
    // Control: the recording of another run under the name of the row is found, and kept.
    fs::copy(&files[0], &files[1]).unwrap();
    let other = bench.call(&restore);
    expect(&other, 5);
    assert!(
        other.err.contains("have the hash") && other.out.contains("1 of 2 runs"),
        "{}",
        other.err
    );
    assert!(fs::read(&files[1]).unwrap() == fs::read(&files[0]).unwrap());
    for (arguments, code, part) in [
        (&["restore", "one/gas", "--where", "replicate=77"][..], 2, "no run"),
        (&["restore", "one/gas", "--where", "replicate"][..], 2, "  | replicate\n  |          ^"),
        (
            &["restore", "one/gas", "--where", "replicate=1", "--output", "one/gas"][..],
            2,
            "replace",
        ),
        (&["restore", "none", "--where", "replicate=1"][..], 5, "does not exist"),
    ] {
        let called = bench.call(arguments);
        expect(&called, code);
        assert!(called.err.contains(part), "{part} in {}", called.err);
    }
}

/// Setup: kills after 20 to 400 ms. Between two of them, the end of the journal is torn off, as by a power loss.
#[test]
fn killed_sweep_resumes_to_the_same_bytes() {
    let bench = Bench::new();
    let expected = table(&bench, 150, "whole", &[]);
    let journal = bench.path("killed/gas/.runs.journal");
    let mut sizes = Vec::new();
    for milliseconds in [20, 90, 150, 60, 200, 400] {
        let mut run = command()
            .current_dir(bench.0.path())
            .args(["run", "--quiet", "kept.toml", "--output", "killed", "--jobs", "2"])
            .spawn()
            .unwrap();
        sleep(Duration::from_millis(milliseconds));
        run.kill().unwrap();
        run.wait().unwrap();
        if let Ok(bytes) = fs::read(&journal) {
            sizes.push(bytes.len());
            fs::write(&journal, &bytes[..bytes.len() - bytes.len().min(13)]).unwrap();
        }
    }
    assert!(table(&bench, 150, "killed", &[]) == expected, "journals of {sizes:?} bytes");
    // A second program is rejected while the first one has the journal, and a foreign file is not overwritten.
    fs::write(&journal, "no journal of this program").unwrap();
    let foreign = bench.call(&["run", "--quiet", "kept.toml", "--output", "killed"]);
    assert_eq!(foreign.code, Some(75), "{}", foreign.err);
    assert_eq!(fs::read(&journal).unwrap(), b"no journal of this program");
}

#[test]
fn rows_of_failed_runs_state_the_fault_and_other_places_are_rejected() {
    let bench = Bench::new();
    let fault = "name = \"fault\"\nreplicates = 2\n[model.dem]\ndiscs = 5\ntime_step_s = 0.01\n\
         on_unstable_time_step = \"warn\"\nduration_s = 1.0\n[record]\nframes = 10\nkeep = \"metrics\"\n";
    let fault: PathBuf = bench.write("fault.toml", fault);
    let failed = bench.call(&["run", "--quiet", fault.to_str().unwrap()]);
    expect(&failed, 1);
    assert!(failed.err.contains("2 of 2 runs ended otherwise than expected"), "{}", failed.err);
    let rows =
        bench.call(&["table", "recordings/fault", "--columns", "outcome", "--format", "csv"]);
    assert_eq!(rows.out, "outcome\nfault\nfault\n");
    bench.write("kept.toml", &sweep(1, "metrics"));
    for option in [&["--output", "s3://bucket/prefix"][..], &["--analyze"]] {
        let rejected = bench.call(&[&["run", "kept.toml"], option].concat());
        expect(&rejected, 2);
        assert!(
            rejected.err.contains("cannot be used with `keep = \"metrics\"`"),
            "{}",
            rejected.err
        );
    }
}

/// Guarantee: finished rows are not dropped by a mistaken manifest, and a table replaces no other kind of file.
#[test]
fn rows_of_other_runs_are_kept_until_they_are_pruned() {
    let bench = Bench::new();
    let first = table(&bench, 2, "kept", &[]);
    for mistaken in ["seed=4", "replicates=1"] {
        let called = bench.call(&["run", "kept.toml", "--output", "kept", "--set", mistaken]);
        expect(&called, 2);
        assert!(
            called.err.contains("that the manifest does not describe\nhelp: name another folder")
        );
        assert!(fs::read(bench.path("kept/gas/runs.parquet")).unwrap() == first, "{mistaken}");
    }
    let pruned = ["run", "--quiet", "--prune", "kept.toml", "--output", "kept", "--set", "seed=4"];
    expect(&bench.call(&pruned), 0);
    assert!(fs::read(bench.path("kept/gas/runs.parquet")).unwrap() != first);
    let into = |file: &str| {
        bench.call(&["table", "kept/gas", "--columns", "replicate", "--format", "csv", "-o", file])
    };
    let manifest = fs::read(bench.path("kept.toml")).unwrap();
    expect(&into("kept.toml"), 2);
    assert!(fs::read(bench.path("kept.toml")).unwrap() == manifest);
    let written = into("kept.csv");
    assert!(written.out.starts_with("written: kept.csv (8 rows)"), "{}", written.out);
}

/// Guarantee: a damaged table gives no number, and the runs of its rows are executed again. Setup: one flipped bit in each seventh of the
/// file.
#[test]
fn damaged_table_is_an_error_until_its_runs_are_executed_again() {
    let bench = Bench::new();
    let whole = table(&bench, 1, "kept", &[]);
    let path = bench.path("kept/gas/runs.parquet");
    for part in 0..7 {
        let mut damaged = whole.clone();
        damaged[(2 * part + 1) * whole.len() / 14] ^= 1 << part;
        fs::write(&path, &damaged).unwrap();
        for asked in [
            &["table", "kept/gas"][..],
            &["restore", "kept/gas", "--where", "replicate=0"],
            &["verify", "kept/gas", "--sample", "4"],
        ] {
            let called = bench.call(asked);
            expect(&called, 5);
            let message = "its checksum is wrong\nhelp: write it again";
            assert!(called.err.contains(message), "{asked:?}: {}", called.err);
        }
        let again = bench.call(&["run", "--quiet", "kept.toml", "--output", "kept"]);
        expect(&again, 0);
        assert!(again.err.contains("the runs of its rows are executed again"), "{}", again.err);
        assert!(fs::read(&path).unwrap() == whole, "part {part}");
    }
}

/// Guarantee: an analysis of the table gives the metrics, checks and plots of one of all recordings, byte for byte, and leaves the table as
/// it is; `why` finds the rows.
#[test]
fn analysis_of_the_table_equals_that_of_the_recordings() {
    let bench = Bench::new();
    let asked = "[[checks]]\nmetric = \"pressure.measured\"\nstandard_errors = 1000\n\
         [[checks]]\nmetric = \"mean_speed\"\nmaximum = 1\n[[plots]]\ny = \"mean_speed\"\n";
    let analyzed = ["all", "metrics"].map(|keep| {
        bench.write("asked.toml", &(sweep(3, keep) + asked));
        expect(&bench.call(&["run", "--quiet", "asked.toml", "--output", keep]), 0);
        let folder = bench.path(keep).join("gas");
        let before = fs::read(folder.join("runs.parquet"));
        let called = bench.call(&["analyze", "--quiet", &format!("{keep}/gas")]);
        expect(&called, 3);
        let names =
            ["metrics.json", "metrics.csv", "runs.parquet", "mean_speed_vs_temperature.svg"];
        let files = names.map(|name| fs::read(folder.join(name)).unwrap());
        assert!(before.is_err() || before.is_ok_and(|table| table == files[2]));
        assert!(folder.join("report.html").exists());
        let data = format!("{keep}/gas");
        let drawn = ["plot", &data, "--y", "mean_speed", "--where", "speed_distribution=maxwell"];
        let drawn = bench.call(&drawn);
        expect(&drawn, 0);
        (files, called.err, drawn.out)
    });
    assert!(analyzed[0].2.starts_with("<svg") && analyzed[0].2 == analyzed[1].2);
    let of_frames = bench.call(&["plot", "metrics/gas", "--y", "/pressure.pressure_n_m"]);
    expect(&of_frames, 2);
    assert!(of_frames.err.contains("kinetoscope restore metrics/gas"), "{}", of_frames.err);
    assert!(analyzed[0].1.contains("checks failed"), "{}", analyzed[0].1);
    assert_eq!(analyzed[0].1, analyzed[1].1);
    for (file, (of_recordings, of_table)) in analyzed[0].0.iter().zip(&analyzed[1].0).enumerate() {
        assert!(of_recordings == of_table, "file {file}");
    }
    // An analysis of fewer recordings keeps the rows of the others.
    let one = recordings(&bench.path("all/gas")).remove(0);
    let part = bench.call(&["analyze", one.to_str().unwrap()]);
    assert!(
        part.out.contains("runs.parquet is kept, because it has rows of 11 runs"),
        "{}",
        part.out
    );
    assert!(fs::read(bench.path("all/gas/runs.parquet")).unwrap() == analyzed[0].0[2]);
    let why = bench.call(&["why", "asked.toml", "--output", "metrics"]).out;
    assert_eq!(why.lines().filter(|line| line.ends_with(": finished")).count(), 12, "{why}");
    let other = ["why", "asked.toml", "--output", "metrics", "--set", "seed=4"];
    assert!(bench.call(&other).out.contains("to do: no row in runs.parquet"));
}

/// Guarantee: the table does not depend on its history. Setup: a moving wall has metrics that a wall at rest lacks.
/// Guarantee: an experiment with too many runs to list them is not analyzed, and its table stays as it is. Its other commands work.
/// Setup: a small sweep whose side file says so.
#[test]
fn table_of_unlisted_runs_is_not_replaced_by_an_analysis() {
    let bench = Bench::new();
    let whole = table(&bench, 2, "one", &[]);
    let record = bench.path("one/gas/experiment.toml");
    let listed = fs::read_to_string(&record).unwrap();
    let (head, runs) = listed.split_once("\n[[axes]]").unwrap();
    let axes = runs.split("\n[[runs]]").next().unwrap();
    fs::write(&record, format!("{head}unlisted_runs = 8\n\n[[axes]]{axes}")).unwrap();
    let analyzed = bench.call(&["analyze", "one/gas"]);
    expect(&analyzed, 5);
    assert!(analyzed.err.contains("has 8 runs") && analyzed.err.contains("kinetoscope table"));
    // A restored recording changes nothing.
    expect(&bench.call(&["restore", "one/gas", "--where", "replicate=1"]), 0);
    let restored = recordings(&bench.path("one/gas/restored"));
    let beside_table = bench.path("one/gas").join(restored[0].file_name().unwrap());
    fs::copy(&restored[0], &beside_table).unwrap();
    expect(&bench.call(&["analyze", "one/gas"]), 5);
    assert!(fs::read(bench.path("one/gas/runs.parquet")).unwrap() == whole);
    expect(&bench.call(&["table", "one/gas", "--group", "temperature_k"]), 0);
    expect(&bench.call(&["verify", "one/gas", "--sample", "3"]), 0);
    // Control: the same folder with its runs listed.
    fs::remove_file(beside_table).unwrap();
    fs::write(&record, listed).unwrap();
    expect(&bench.call(&["analyze", "--quiet", "one/gas"]), 0);
}

#[test]
fn removed_runs_leave_no_columns() {
    let bench = Bench::new();
    let written = |speeds: &str, output: &str| {
        let manifest = format!(
            "name = \"gas\"\n[model.gas]\nparticles = 20\nduration_s = 0.001\n\
             [record]\nframes = 4\nkeep = \"metrics\"\n[sweep]\n\"model.gas.wall_speed_m_per_s\" = {speeds}\n"
        );
        bench.write("wall.toml", &manifest);
        expect(&bench.call(&["run", "-q", "--prune", "wall.toml", "--output", output]), 0);
        fs::read(bench.path(output).join("gas/runs.parquet")).unwrap()
    };
    let (both, few) = (written("[0, 50]", "kept"), written("[0]", "kept"));
    let other = written("[0]", "scratch");
    assert!(both != few && few == other);
}

/// The place of the footer of a table, after its checksum.
fn footer(table: &[u8]) -> Option<usize> {
    let (rest, tail) = table.split_last_chunk::<8>()?;
    rest.len().checked_sub(u32::from_le_bytes(tail[..4].try_into().unwrap()) as usize)
}

/// Setup: up to three changed bytes, half of them in the footer. Every second table has a correct checksum nevertheless, as a forged one;
/// only these may be read. Prints how often each exit code was seen.
#[test]
#[ignore = "a campaign of minutes: set MUTATIONS to the number of tables"]
fn full_harness_damaged_tables() {
    let bench = Bench::new();
    let whole = table(&bench, 1, "kept", &[]);
    let start = footer(&whole).unwrap();
    let bare = [&whole[..start - 32], &whole[start..]].concat();
    let number = std::env::var("MUTATIONS").map_or(2000, |number| number.parse().unwrap());
    let mut state = 1_u64;
    // SplitMix64.
    let mut next = |below: usize| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % below as u64) as usize
    };
    let mut codes = BTreeMap::<(bool, Option<i32>), usize>::new();
    for mutation in 0..number {
        let is_forged = mutation % 2 == 1;
        let mut table = if is_forged { bare.clone() } else { whole.clone() };
        for _ in 0..=next(3) {
            let from = if next(2) == 0 { 0 } else { table.len() - (whole.len() - start) };
            let at = from + next(table.len() - from);
            table[at] = if next(2) == 0 { table[at] ^ (1 << next(8)) } else { next(256) as u8 };
        }
        if is_forged && let Some(at) = footer(&table) {
            let sum = Sha256::digest(&table);
            table.splice(at..at, sum);
        }
        if table == whole {
            continue;
        }
        fs::write(bench.path("kept/gas/runs.parquet"), &table).unwrap();
        let called = bench.call(match mutation % 5 {
            0 | 1 => &["table", "kept/gas"],
            2 => &["table", "kept/gas", "--group", "temperature_k", "--format", "json"],
            3 => &["restore", "kept/gas", "--where", "replicate=0"],
            _ => &["verify", "kept/gas", "--sample", "2"],
        });
        let is_right = called.code == Some(5) || is_forged && matches!(called.code, Some(0..=2));
        assert!(is_right, "table {mutation}: {:?}\n{}{}", called.code, called.out, called.err);
        *codes.entry((is_forged, called.code)).or_default() += 1;
    }
    println!("(has a correct checksum, exit code): tables: {codes:?}");
}
