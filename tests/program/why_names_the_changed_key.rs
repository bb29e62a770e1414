//! Guarantee: `kinetoscope why` reports for each run whether it will be executed, and which key, version or file is the reason; it executes no run.
//! A description or a check is not a reason; the seed is.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::forged_recording::{Forgery, kinetoscope, record, recordings, stderr, stdout};
use kinetoscope_recording::reader::Recording;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

const GAS: &str = "name = \"gas\"\nseed = 6\n[model.gas]\nparticles = 50\nduration_s = 0.02\n[record]\nframes = 20\n";

/// The output for a manifest; `set` contains values from the command line.
fn why(folder: &Path, manifest: &str, set: &[&str]) -> String {
    let path = folder.join("asked.toml");
    fs::write(&path, manifest).unwrap();
    let output = folder.join("recordings");
    let before = recordings(&output.join("gas"));
    let mut arguments = vec![PathBuf::from("why"), "--output".into(), output.clone(), path];
    for value in set {
        arguments.extend(["--set".into(), value.into()]);
    }
    let asked = kinetoscope(&arguments);
    assert_eq!(asked.status.code(), Some(0), "{}", stderr(&asked));
    assert_eq!(recordings(&output.join("gas")), before, "no run must be executed");
    stdout(&asked)
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

#[test]
fn descriptions_and_checks_are_not_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(why(folder.path(), GAS, &[]), "gas: to do: never recorded\n");
    record(folder.path(), "gas", GAS);
    assert_eq!(why(folder.path(), GAS, &[]), "gas: finished\n");
    let described = format!(
        "description = \"Another.\"\n{GAS}\n[[checks]]\nmetric = \"temperature.mean_square\"\nexpected = 1.0\n\
         relative_tolerance = 0.1\n"
    );
    assert_eq!(why(folder.path(), &described, &[]), "gas: finished\n");
}

#[test]
fn changed_keys_are_named_relative_to_the_nearest_recording() {
    let folder = tempfile::tempdir().unwrap();
    let first = file_name(&record(folder.path(), "gas", GAS));
    let expected = format!("gas: to do: differs from {first}\n    seed: 6 → 7\n");
    assert_eq!(why(folder.path(), GAS, &["seed=7"]), expected);

    let second = GAS.replace("seed = 6", "seed = 7").replace("particles = 50", "particles = 60");
    let second = file_name(&record(folder.path(), "gas", &second));
    // Seed 7 and 61 particles: one key from the second recording, two from the first.
    let asked = why(folder.path(), GAS, &["seed=7", "model.gas.particles=61"]);
    let expected = format!("gas: to do: differs from {second}\n    model.gas.particles: 60 → 61\n");
    assert_eq!(asked, expected);
}

#[test]
fn each_point_of_a_sweep_has_its_own_reason() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = |values: &str| format!("{GAS}[sweep]\n\"model.gas.particles\" = [{values}]\n");
    let recording = record(folder.path(), "gas", &sweep("50"));
    let file = file_name(&recording);
    let asked = why(folder.path(), &sweep("50, 60"), &["seed=8"]);
    let expected = format!(
        "model.gas.particles = 50: to do: differs from {file}\n    seed: 6 → 8\n\
         model.gas.particles = 60: to do: never recorded\n"
    );
    assert_eq!(asked, expected);
    // Without the sweep, the same run has another name.
    let expected = format!("gas: to do: recorded as {file}, which has another name\n");
    assert_eq!(why(folder.path(), GAS, &[]), expected);
}

#[test]
fn versions_and_damaged_files_are_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "gas", GAS);
    let provenance = Recording::open(&recording).unwrap().provenance().clone();
    let older = recording.with_file_name("gas__0123abcd.mcap");
    let forge = |key: &str, value: String| {
        let metadata =
            BTreeMap::from([(key.to_owned(), value), ("run_key".to_owned(), "0123abcd".repeat(8))]);
        Forgery { metadata, ..Forgery::default() }.write(&recording, &older);
    };
    let now = provenance.physics_version;
    forge("physics_version", (now + 1).to_string());
    fs::rename(&recording, folder.path().join("aside.mcap")).unwrap();
    let expected = format!(
        "gas: to do: differs from gas__0123abcd.mcap\n    physics version: {} → {now}\n",
        now + 1
    );
    assert_eq!(why(folder.path(), GAS, &[]), expected);

    fs::rename(folder.path().join("aside.mcap"), &recording).unwrap();
    forge("schema_version", "77".to_owned());
    fs::rename(&recording, folder.path().join("aside.mcap")).unwrap();
    let asked = why(folder.path(), GAS, &[]);
    let expected = format!("    schema version: 77 → {}\n", provenance.schema_version);
    assert!(asked.ends_with(&expected), "{asked}");

    let bytes = fs::read(folder.path().join("aside.mcap")).unwrap();
    fs::write(&recording, &bytes[..bytes.len() / 2]).unwrap();
    let asked = why(folder.path(), GAS, &[]);
    assert!(asked.starts_with("gas: to do: ") && asked.contains("has no end"), "{asked}");

    let stem = file_name(&recording).replace(".mcap", "");
    fs::rename(&recording, recording.with_file_name(format!("{stem}.partial.mcap"))).unwrap();
    let expected = format!("gas: to do: {stem}.partial.mcap is unfinished\n");
    assert_eq!(why(folder.path(), GAS, &[]), expected);
}

#[test]
fn impossible_run_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("unstable.toml");
    // The model rejects time steps at which such a strong damping diverges.
    fs::write(&path, "[model.dem]\ndamping_n_s_per_m = 1.5e3\n").unwrap();
    let asked = kinetoscope(["why".as_ref(), path.as_os_str()]);
    assert_eq!(asked.status.code(), Some(2), "{}", stderr(&asked));
    assert!(stdout(&asked).starts_with("unstable: rejected: "), "{}", stdout(&asked));
}

/// Setup: 60 replicates of two particles, of which one is removed after all were recorded. Control: of 50, each is listed.
#[test]
fn many_runs_are_counted_by_their_reasons_and_listed_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let many = |runs: u32| {
        format!("replicates = {runs}\n{GAS}").replace("particles = 50", "particles = 2")
    };
    let asked = |runs: u32, set: &[&str]| why(folder.path(), &many(runs), set);
    assert!(asked(60, &[]).starts_with("gas: 60 runs\n  60 to do: never recorded\n--list FILE"));
    let manifest = folder.path().join("asked.toml");
    let output = folder.path().join("recordings");
    let run = [PathBuf::from("run"), "--quiet".into(), "--output".into(), output.clone(), manifest];
    assert_eq!(kinetoscope(&run).status.code(), Some(0));
    fs::remove_file(&recordings(&output.join("gas"))[0]).unwrap();
    assert!(asked(60, &[]).starts_with("gas: 60 runs\n  59 finished\n  1 to do: never recorded\n"));
    assert!(asked(60, &["seed=7"]).starts_with("gas: 60 runs\n  59 to do: differs in seed\n"));
    assert_eq!(asked(50, &[]).lines().count(), 50);
    let list = folder.path().join("list.txt");
    let manifest = folder.path().join("asked.toml");
    fs::write(&manifest, many(60)).unwrap();
    let why = ["why".into(), "--list".into(), list.clone(), "--output".into(), output, manifest];
    let counted = stdout(&kinetoscope(&why));
    assert!(counted.contains("59 finished") && counted.contains("list.txt"), "{counted}");
    assert_eq!(fs::read_to_string(list).unwrap().lines().count(), 60);
}
