//! Promise: what the plan says of particles, frames and bytes holds for all its runs, for discs that fall in, too. Control: without
//! them the plan would be less than what their run writes.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;
use std::process::Command;

/// The plan of a manifest as it is printed, and the bytes of its recordings.
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

/// The bound of a plan in bytes.
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
fn discs_that_fall_in_are_counted() {
    let scene = "[model.dem]\ndiscs = 1\nduration_s = 0.5\n[record]\nframes = 100\n";
    let rain = "[model.dem.rain]\ndiscs = 200\ndiscs_per_s = 1e3\nfrom_m = [0.005, 0.035]\nto_m = [0.035, 0.035]\n\
        velocity_m_per_s = [0.0, -0.5]\n";
    let (plan, bytes) = planned_and_recorded(&format!("{scene}{rain}"));
    assert!(plan.contains("201 particles, 101 frames, at most"), "{plan}");
    assert!(bytes as f64 <= bound(&plan), "{bytes} bytes, and {plan}");
    let (dry, _) = planned_and_recorded(scene);
    assert!(dry.contains("1 particle, 101 frames, at most"), "{dry}");
    assert!(bytes as f64 > bound(&dry), "control: {bytes} bytes, and {dry}");
}

#[test]
fn a_sweep_is_told_from_the_fewest_to_the_most() {
    let (plan, bytes) = planned_and_recorded(
        "[model.packing]\nduration = 1.0\n[record]\nframes = 4\n[sweep]\n\"model.packing.discs\" = [10, 50, 5]\n",
    );
    assert!(plan.contains("5 to 50 particles, 5 frames, at most"), "{plan}");
    assert!(bytes as f64 <= bound(&plan), "{bytes} bytes, and {plan}");
}

#[test]
fn a_series_that_no_plan_can_count_is_told() {
    let manifest = "[model.packing]\n[record]\nframes = 1\n";
    let (plan, _) = planned_and_recorded(manifest);
    let (series, bytes) =
        planned_and_recorded(&format!("{manifest}channels = [\"state\", \"per_collision\"]\n"));
    let word = "plus the requested series of collisions or contacts";
    assert!(series.contains(word) && bytes as f64 > bound(&series), "{bytes} bytes, and {series}");
    assert!(!plan.contains(word), "control: {plan}");
}
