//! Promise: `kinetoscope compare` names the keys of the two manifests that differ, then versions, then the first message that differs; equal
//! messages are exit code 0, others 4.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

mod forged_recording;

use forged_recording::{Forgery, kinetoscope, record, stderr, stdout};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Output;

const GAS: &str =
    "seed = 6\n[model.gas]\nparticles = 50\nduration_s = 0.02\n[record]\nframes = 20\n";

fn compare(left: &Path, right: &Path) -> Output {
    kinetoscope(["compare".as_ref(), left.as_os_str(), right.as_os_str()])
}

#[test]
fn a_copy_is_equal_in_every_byte() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "gas", GAS);
    let copy = folder.path().join("copy.mcap");
    fs::copy(&recording, &copy).unwrap();
    let compared = compare(&recording, &copy);
    assert_eq!(compared.status.code(), Some(0), "{}", stderr(&compared));
    assert!(stdout(&compared).contains("equal manifests\n21 frames: equal in every byte"));
}

#[test]
fn keys_come_before_messages() {
    let folder = tempfile::tempdir().unwrap();
    let one = record(folder.path(), "gas", GAS);
    let warmer = GAS.replace("particles = 50", "particles = 60\ntemperature_k = 373.15");
    let other = record(folder.path(), "gas", &warmer);
    let compared = compare(&one, &other);
    assert_eq!(compared.status.code(), Some(4));
    let text = stdout(&compared);
    let keys: Vec<&str> = text.lines().filter(|line| line.starts_with("  ")).collect();
    let expected = ["  model.gas.particles: 50 → 60", "  model.gas.temperature_k: 300.0 → 373.15"];
    assert_eq!(keys, expected, "the keys that differ, and no other");
    assert!(text.contains("\ncontent key: "), "{text}");
    assert!(
        stderr(&compared).contains("first difference: /state, frame 0 (time 0.0 s), particle 0, ")
    );
}

#[test]
fn another_compression_has_the_same_messages() {
    let folder = tempfile::tempdir().unwrap();
    let one = record(folder.path(), "gas", GAS);
    let other = record(folder.path(), "gas", &format!("{GAS}compression = \"lz4\"\n"));
    let compared = compare(&one, &other);
    assert_eq!(compared.status.code(), Some(0), "{}", stderr(&compared));
    let text = stdout(&compared);
    assert!(text.contains("  record.compression: \"zstd\" → \"lz4\"\n"), "{text}");
    assert!(text.contains("21 frames: equal in every message, not in every byte"), "{text}");
}

#[test]
fn a_longer_run_is_equal_up_to_the_end_of_the_shorter() {
    let folder = tempfile::tempdir().unwrap();
    let short = record(folder.path(), "gas", GAS);
    let twice = GAS.replace("duration_s = 0.02", "duration_s = 0.04");
    let long = record(folder.path(), "gas", &twice.replace("frames = 20", "frames = 40"));
    let compared = compare(&short, &long);
    assert_eq!(compared.status.code(), Some(4));
    // Frame 0 says in its log what a second of playback stands for; it is the same here, as is all up to frame 20.
    let expected =
        format!("number of frames: {} has only 21 (complete), all of them equal", short.display());
    assert!(stderr(&compared).contains(&expected), "{}", stderr(&compared));
}

#[test]
fn other_versions_and_other_units_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "gas", GAS);
    let other = folder.path().join("other.mcap");
    let metadata = BTreeMap::from([("physics_version".to_owned(), "77".to_owned())]);
    Forgery { metadata, ..Forgery::default() }.write(&recording, &other);
    let compared = compare(&recording, &other);
    assert_eq!(compared.status.code(), Some(0), "{}", stderr(&compared));
    assert!(stdout(&compared).contains("→ 77\n"), "{}", stdout(&compared));

    let metadata = BTreeMap::from([("time_unit".to_owned(), "min".to_owned())]);
    Forgery { metadata, ..Forgery::default() }.write(&recording, &other);
    let compared = compare(&recording, &other);
    assert_eq!(compared.status.code(), Some(4), "numbers of another unit are other numbers");
    assert!(stderr(&compared).contains("first difference: time unit: \"s\" in "));
}
