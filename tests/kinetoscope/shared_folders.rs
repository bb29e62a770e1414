//! Guarantee: whatever other users and other processes put into a folder of recordings, no command destroys the run of another
//! process, writes outside of the folder, or blocks.

#![cfg(target_os = "linux")]

use super::{Bench, recordings};
use std::fs::{self, File};
use std::path::Path;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// The lock stands for a process that runs an earlier manifest again (`--force`).
#[test]
fn pruning_keeps_all_files_of_a_run_that_another_process_writes() {
    let bench = Bench::new();
    let old = bench.recording();
    bench.write("gas.toml", &super::GAS.replace("seed = 1", "seed = 2"));
    assert_eq!(bench.call(&["run", "--quiet", "gas.toml"]).code, Some(0));
    let folder = bench.path("recordings/gas");
    fs::write(old.with_extension("checkpoint"), "state").unwrap();
    let partial = File::create(old.with_extension("partial.mcap")).unwrap();
    partial.try_lock().unwrap();
    let before = names(&folder);
    let pruned = bench.call(&["run", "--prune", "gas.toml"]);
    assert_eq!(pruned.code, Some(0), "{}", pruned.err);
    assert_eq!(names(&folder), before);
    assert!(!pruned.out.contains("stale, removed"), "{}", pruned.out);
    assert!(pruned.out.contains("another process is writing this run"), "{}", pruned.out);
    drop(partial);
    let pruned = bench.call(&["run", "--prune", "gas.toml"]);
    assert_eq!(pruned.code, Some(0), "{}", pruned.err);
    assert!(pruned.out.contains("stale, removed"), "{}", pruned.out);
    assert_eq!(recordings(&folder).len(), 1);
    let stem = old.file_stem().unwrap().to_str().unwrap();
    assert!(!names(&folder).iter().any(|name| name.starts_with(stem)), "{:?}", names(&folder));
}
