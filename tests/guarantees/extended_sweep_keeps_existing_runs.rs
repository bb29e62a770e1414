//! Guarantee: an additional replicate or value of a sweep changes neither the keys nor the bytes of the existing runs.
//!
//! Control: another seed changes all keys and bytes.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

/// Recordings by run key, which is the end of the file name.
fn recorded(seed: u32, replicates: u32, temperatures: &str) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("sweep.toml");
    let text = format!(
        "seed = {seed}\nreplicates = {replicates}\n[model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 4\n\
         [sweep]\n\"model.gas.temperature_k\" = [{temperatures}]\n"
    );
    fs::write(&manifest, text).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_run-experiment"));
    program.arg(&manifest).arg("--output").arg(folder.path());
    assert!(program.output().unwrap().status.success());
    let entries =
        fs::read_dir(folder.path().join("sweep")).unwrap().map(|entry| entry.unwrap().path());
    entries
        .filter(|path| path.extension().is_some_and(|extension| extension == "mcap"))
        .map(|path| {
            let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
            (stem.rsplit_once("__").unwrap().1.to_owned(), fs::read(&path).unwrap())
        })
        .collect()
}

#[test]
fn existing_runs_keep_their_keys_and_bytes() {
    let before = recorded(1, 2, "200.0, 300.0");
    assert_eq!(before.len(), 4);
    for (grown, runs) in
        [(recorded(1, 3, "200.0, 300.0"), 6), (recorded(1, 2, "100.0, 200.0, 300.0"), 6)]
    {
        assert_eq!(grown.len(), runs);
        assert!(before.iter().all(|(key, bytes)| grown.get(key) == Some(bytes)));
        let distinct: std::collections::BTreeSet<&Vec<u8>> = grown.values().collect();
        assert_eq!(distinct.len(), runs, "two runs have the same bytes");
    }
    let other = recorded(2, 2, "200.0, 300.0");
    assert!(before.keys().all(|key| !other.contains_key(key)), "control");
}
