//! Guarantee: recording a large DEM bed takes at most 400 bytes of memory per disc, and at most 450 with friction, which needs
//! springs. The program itself is included, from its start to the last byte of the recording.
//!
//! Setup: the bed of `src/program/allocator.rs` with fewer discs: a lattice with random velocities, in which some discs touch at any
//! time, recorded twice. As with 10^6 discs, one frame at a time is in memory (56 MB). The neighbor lists are rebuilt several times,
//! so memory that an old list leaves allocated counts. The operating system measures the peak; `STEM.host.json` reports it.
//! Control: the peak must exceed the memory that is certainly needed per disc: 69 bytes of columns and 80 of the row in a frame.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]
#![cfg(target_os = "linux")]

use crate::forged_recording::{run_experiment, stderr};
use std::fs;
use std::path::PathBuf;

const DISCS: u64 = 700_000;
const COLUMNS_AND_ROW: u64 = 69 + 80;

/// Peak memory of a run of the bed in bytes per disc.
fn bytes_per_disc(more: &str) -> u64 {
    // The box of 10^6 discs is 1.03 m wide.
    let side = 1.03 * (DISCS as f64 / 1e6).sqrt();
    let manifest = format!(
        "seed = 5\n[model.dem]\ndiscs = {DISCS}\nwidth_m = {side}\nheight_m = {side}\nduration_s = 0.001\n\
         stiffness_n_per_m = 4e5\nplacement = \"lattice\"\nvelocity_std_m_per_s = 0.3\n{more}\n[record]\nevery_steps = 70\n"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bed.toml");
    let output = folder.path().join("recordings");
    fs::write(&path, manifest).unwrap();
    let ran = run_experiment(&[path, PathBuf::from("--output"), output.clone()]);
    assert!(ran.status.success(), "{}", stderr(&ran));
    let files = fs::read_dir(output.join("bed")).unwrap().map(|entry| entry.unwrap().path());
    let mut hosts = files.filter(|path| path.to_string_lossy().ends_with(".host.json"));
    let host = fs::read_to_string(hosts.next().unwrap()).unwrap();
    let host: serde_json::Value = serde_json::from_str(&host).unwrap();
    assert!(host["frames"].as_u64().unwrap() >= 2, "{host}");
    host["peak_memory_of_the_program_bytes"].as_u64().unwrap() / DISCS
}

#[test]
#[ignore = "two beds of 700,000 discs"]
fn memory_per_disc_of_a_recorded_bed_is_bounded() {
    for (name, more, at_most) in
        [("frictionless", "", 400), ("with friction", "friction = 0.5", 450)]
    {
        let bytes = bytes_per_disc(more);
        println!("{name}: {bytes} bytes per disc");
        assert!((COLUMNS_AND_ROW..=at_most).contains(&bytes), "{name}: {bytes} bytes per disc");
    }
}
