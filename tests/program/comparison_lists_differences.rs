//! Guarantee: `kinetoscope compare` lists the keys in which two manifests differ, then versions, then the first message that differs. The exit code
//! is 0 for equal messages and 4 otherwise.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::forged_recording::{Forgery, kinetoscope, record, stderr, stdout};
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
fn copy_is_byte_identical() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "gas", GAS);
    let copy = folder.path().join("copy.mcap");
    fs::copy(&recording, &copy).unwrap();
    let compared = compare(&recording, &copy);
    assert_eq!(compared.status.code(), Some(0), "{}", stderr(&compared));
    assert!(stdout(&compared).contains("equal manifests\n21 frames: equal in every byte"));
}

#[test]
fn keys_are_listed_before_messages() {
    let folder = tempfile::tempdir().unwrap();
    let one = record(folder.path(), "gas", GAS);
    let warmer = GAS.replace("particles = 50", "particles = 60\ntemperature_k = 373.15");
    let other = record(folder.path(), "gas", &warmer);
    let compared = compare(&one, &other);
    assert_eq!(compared.status.code(), Some(4));
    let text = stdout(&compared);
    let keys: Vec<&str> = text.lines().filter(|line| line.starts_with("  ")).collect();
    let expected = ["  model.gas.particles: 50 → 60", "  model.gas.temperature_k: 300.0 → 373.15"];
    assert_eq!(keys, expected, "exactly the differing keys must be listed");
    assert!(text.contains("\nrun key: "), "{text}");
    assert!(
        stderr(&compared).contains("first difference: /state, frame 0 (time 0.0 s), particle 0, ")
    );
}

#[test]
fn compression_does_not_affect_messages() {
    let folder = tempfile::tempdir().unwrap();
    let one = record(folder.path(), "gas", GAS);
    let other = record(folder.path(), "gas", &format!("{GAS}compression = \"lz4\"\n"));
    let compared = compare(&one, &other);
    assert_eq!(compared.status.code(), Some(0), "{}", stderr(&compared));
    let text = stdout(&compared);
    assert!(text.contains("  record.compression: \"zstd\" → \"lz4\"\n"), "{text}");
    assert!(text.contains("21 frames: equal in every message, not in every byte"), "{text}");
}

/// Control: another state at a keyframe is a difference.
#[test]
fn full_and_keyframe_recordings_are_compared_in_what_both_have() {
    let folder = tempfile::tempdir().unwrap();
    let full = record(folder.path(), "full", GAS);
    let keep = "keep = \"keyframes\"\nkeyframe_distance = 10\n";
    let keyframes = record(folder.path(), "keyframes", &format!("{GAS}{keep}"));
    for pair in [[&full, &keyframes], [&keyframes, &full]] {
        let compared = compare(pair[0], pair[1]);
        assert_eq!(compared.status.code(), Some(0), "{}", stderr(&compared));
        let text = stdout(&compared);
        let equal = "equal in every message that both recordings have";
        assert!(text.contains(equal), "{text}");
        let (_, named) = text.split_once("because it keeps other frames: ").unwrap();
        for topic in ["/discs", "/keyframe", "/log", "/state", "/velocity"] {
            assert!(named.contains(topic), "{topic}: {text}");
        }
        assert!(!named.contains("/pressure"), "{text}");
    }
    let warmer = GAS.replace("particles = 50", "particles = 50\ntemperature_k = 373.15");
    let other = record(folder.path(), "warmer", &format!("{warmer}{keep}"));
    let compared = compare(&full, &other);
    assert_eq!(compared.status.code(), Some(4));
    assert!(
        stderr(&compared).contains("first difference: /state, frame 0 (time 0.0 s), particle 0, ")
    );
}

#[test]
fn longer_run_equals_the_shorter_up_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let short = record(folder.path(), "gas", GAS);
    let twice = GAS.replace("duration_s = 0.02", "duration_s = 0.04");
    let long = record(folder.path(), "gas", &twice.replace("frames = 20", "frames = 40"));
    let compared = compare(&short, &long);
    assert_eq!(compared.status.code(), Some(4));
    // The log of frame 0 states the simulated time per second of playback, which is equal here; so are all frames up to 20.
    let expected =
        format!("number of frames: {} has only 21 (complete), all of them equal", short.display());
    assert!(stderr(&compared).contains(&expected), "{}", stderr(&compared));
}

#[test]
fn differing_versions_and_units_are_named() {
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

/// The exact gas has no steps, so the runs are compared at the times of the other one's steps. Control: another temperature.
#[test]
fn first_step_is_found_if_only_one_run_has_steps() {
    let folder = tempfile::tempdir().unwrap();
    let steps = "propagation = \"time-stepped\"\ntime_step_s = 1e-4\nduration_s";
    let exact = record(folder.path(), "gas", GAS);
    let stepped = record(folder.path(), "gas", &GAS.replace("duration_s", steps));
    let found = |one: &Path, other: &Path| {
        stdout(&kinetoscope([
            "compare".as_ref(),
            one.as_os_str(),
            other.as_os_str(),
            "--find-step".as_ref(),
        ]))
    };
    for text in [found(&exact, &stepped), found(&stepped, &exact)] {
        assert!(
            text.contains("states differ from 1 step or event, at time 0.0001 s, on"),
            "{text}"
        );
        assert!(text.contains("as small as rounding errors"), "{text}");
    }
    // A warmer gas differs from the start; the same gas with other steps has no common steps.
    let warmer = GAS.replace("duration_s", "temperature_k = 310.0\nduration_s");
    let text = found(&stepped, &record(folder.path(), "gas", &warmer));
    assert!(
        text.contains("states differ from frame 0 on") && text.contains("other initial values")
    );
    let finer = GAS.replace("duration_s", &steps.replace("1e-4", "5e-5"));
    let text = found(&stepped, &record(folder.path(), "gas", &finer));
    assert!(
        text.contains("only frames were compared, not steps: the runs have other time steps"),
        "{text}"
    );
    assert!(!text.contains("other initial values"), "{text}");
}

/// A free gas in a circle is not chaotic: its separation grows by a power of time. Control: colliding discs.
#[test]
fn rate_of_growth_is_printed_for_chaotic_runs_only() {
    let folder = tempfile::tempdir().unwrap();
    let compared = |manifest: &str, old: &str, new: &str| {
        let one = record(folder.path(), "one", manifest);
        stdout(&compare(&one, &record(folder.path(), "other", &manifest.replace(old, new))))
    };
    let steps = "propagation = \"time-stepped\"\ntime_step_s = 1e-4\nduration_s";
    let text = compared(GAS, "duration_s", steps);
    assert!(
        text.contains(" in frame 20 (relative to the largest value of the column), "),
        "{text}"
    );
    assert!(text.contains("as small as rounding errors\n"), "{text}");
    let discs = "seed = 6\n[model.gas]\nparticles = 50\ndisc_radius_m = 0.03\nduration_s = 0.02\n[record]\nframes = 40\n";
    let text = compared(discs, "0.03", "0.030000000000000002");
    let rate = text.split("as small as rounding errors, amplified by a factor of e per ").nth(1);
    assert!(rate.is_some_and(|rate| rate.lines().next().unwrap().ends_with(" s")), "{text}");
}
