//! Guarantee: the plan's particles, frames and bytes are upper bounds for all of its runs, including inserted discs.
//!
//! Control: without the inserted discs, the planned size is smaller than the recording.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;
use std::process::Command;

/// The printed plan of a manifest, and the size of its recordings in bytes.
fn planned_and_recorded(manifest: &str) -> (String, u64) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.toml");
    fs::write(&path, manifest).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_run-experiment"));
    let output = program.arg(&path).arg("--output").arg(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let bytes = fs::read_dir(folder.path().join("plan"))
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| Path::new(&entry.file_name()).extension().is_some_and(|end| end == "mcap"))
        .map(|entry| entry.metadata().unwrap().len())
        .sum();
    (String::from_utf8(output.stdout).unwrap(), bytes)
}

/// The size limit that a plan states, in bytes.
fn bound(plan: &str) -> f64 {
    let (_, bound) = plan.split_once("at most ").unwrap();
    let mut words = bound.split_whitespace();
    let number: f64 = words.next().unwrap().parse().unwrap();
    match words.next().unwrap().trim_end_matches(',') {
        "KiB" => 1024.0 * number,
        "MiB" => 1024.0 * 1024.0 * number,
        unit => panic!("{unit} in {plan}"),
    }
}

#[test]
fn inserted_discs_are_counted() {
    let scene = "[model.dem]\ndiscs = 1\nduration_s = 0.5\n[record]\nframes = 100\n";
    let insertion = "[model.dem.insertion]\ndiscs = 200\ndiscs_per_s = 1e3\nfrom_m = [0.005, 0.035]\nto_m = [0.035, 0.035]\n\
        velocity_m_per_s = [0.0, -0.5]\n";
    let (plan, bytes) = planned_and_recorded(&format!("{scene}{insertion}"));
    assert!(plan.contains("201 particles, 101 frames, at most"), "{plan}");
    assert!(bytes as f64 <= bound(&plan), "{bytes} bytes, and {plan}");
    let (dry, _) = planned_and_recorded(scene);
    assert!(dry.contains("1 particle, 101 frames, at most"), "{dry}");
    assert!(bytes as f64 > bound(&dry), "control: {bytes} bytes, and {dry}");
}

/// What `check` prints for a check of a single bed, or of two, with these limits.
fn printed_check(replicates: u32, limit: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.toml");
    let manifest = format!(
        "replicates = {replicates}\n[model.dem]\ndiscs = 20\n[[checks]]\nmetric = \"bed.height\"\nexpected = 0.01\n{limit}\n"
    );
    fs::write(&path, manifest).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_kinetoscope"));
    let output = program.arg("check").arg(&path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Control: two beds, and a tolerance.
#[test]
fn check_names_a_limit_in_standard_errors_that_a_single_bed_does_not_have() {
    let line = "line 4: `bed.height` of a single run has no standard error";
    let single = printed_check(1, "standard_errors = 4.0");
    assert!(single.contains(line), "{single}");
    for (replicates, limit) in [(2, "standard_errors = 4.0"), (1, "relative_tolerance = 0.1")] {
        let other = printed_check(replicates, limit);
        assert!(!other.contains("no standard error"), "control: {other}");
    }
}

#[test]
fn plan_of_a_sweep_states_minimum_and_maximum() {
    let (plan, bytes) = planned_and_recorded(
        "[model.packing]\nduration = 1.0\n[record]\nframes = 4\n[sweep]\n\"model.packing.discs\" = [10, 50, 5]\n",
    );
    assert!(plan.contains("5 to 50 particles, 5 frames, at most"), "{plan}");
    assert!(bytes as f64 <= bound(&plan), "{bytes} bytes, and {plan}");
}

/// The collisions of a run of a given number of events are in its space; of a run of a given duration, their number is unknown.
#[test]
fn series_of_collisions_is_in_the_space_or_named() {
    let recorded = |keys: &str, channel: &str| {
        planned_and_recorded(&format!(
            "[model.packing]\n{keys}[record]\nframes = 1\nchannels = [\"state\", \"{channel}\"]\n"
        ))
    };
    let word = "plus the requested series of collisions or contacts";
    let (without, plain_bytes) = recorded("", "temperature");
    for channel in ["per_collision", "events"] {
        let (plan, bytes) = recorded("", channel);
        assert!(!plan.contains(word) && bytes as f64 <= bound(&plan), "{bytes} bytes, and {plan}");
        assert!(bytes > 2 * plain_bytes && bound(&plan) > bound(&without), "control: {bytes}");
        let (plan, _) = recorded("duration = 5.0\n", channel);
        assert!(plan.contains(word), "{plan}");
    }
    assert!(!without.contains(word), "control: {without}");
}

/// The time of such a run is measured at its start, when the discs still collide. Controls: elastic discs, walls, and a run of a given duration.
#[test]
fn check_states_that_parallel_motion_is_not_in_the_time() {
    let printed = |keys: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cooling.toml");
        fs::write(&path, format!("[model.packing]\n{keys}\n")).unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_kinetoscope"));
        let output = program.arg("check").arg(&path).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let note = "not included in the time: inelastic discs in a periodic box";
    let cooling = "restitution = 0.9\nboundary = \"periodic\"\nevents_per_disc = 20";
    let plan = printed(cooling);
    assert!(plan.contains(note), "{plan}");
    for control in [
        "restitution = 1.0\nboundary = \"periodic\"\nevents_per_disc = 20",
        "restitution = 0.9\nboundary = \"walls\"\nevents_per_disc = 20",
        "restitution = 0.9\nboundary = \"periodic\"\nduration = 1.0",
    ] {
        let plan = printed(control);
        assert!(!plan.contains(note), "control: {plan}");
    }
}
